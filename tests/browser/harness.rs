//! Tests of the browser harness on a fixed page. If they fail, the client is not the reason.

use std::time::Duration;

use crate::support::chromium::{Chromium, pixel_scale};
use crate::support::page::{KeyPress, Page};
use crate::support::picture::Area;
use crate::support::wait_for;

const PAGE: &str = "data:text/html,<!doctype html>
    <body style='margin:0;background:rgb(13,17,23)'>
    <canvas id='c' width='100' height='100' style='position:fixed;left:200px;top:200px'></canvas>
    <button onclick='message.textContent=`clicked`' style='position:fixed;left:20px;top:20px'>Start</button>
    <button disabled>Stop</button><div role='status' aria-label='Message' id='message'></div>
    <script>
      onkeydown = (e) => message.textContent = `down ` %2B e.code;
      const gl = c.getContext(`webgl2`);
      gl.clearColor(1, 0.5, 0, 1); gl.clear(gl.COLOR_BUFFER_BIT);
    </script>";

#[test]
fn roles_names_keys_and_pixels_of_a_page_are_read() {
    let Some(browser) = Chromium::start() else { return };
    let mut page = browser.open(640, 480);
    page.go(PAGE);
    let expect_message = |page: &mut Page, text: &str| {
        wait_for(text, Duration::from_secs(20), || {
            let status = page.find("status", "Message")?;
            (page.text(&status)? == text).then_some(())
        });
    };
    page.click("button", "Start");
    expect_message(&mut page, "clicked");
    page.key_down(KeyPress::W);
    expect_message(&mut page, "down KeyW");
    assert!(page.find("button", "Stop").unwrap().disabled);
    assert!(page.find("button", "Nothing").is_none());

    let picture = page.screenshot();
    let drawn = |px: f64| (px * pixel_scale()).round() as usize;
    let area = |left, top, right, bottom| Area {
        left: drawn(left),
        top: drawn(top),
        right: drawn(right),
        bottom: drawn(bottom),
    };
    assert_eq!((picture.width, picture.height), (drawn(640.0), drawn(480.0)));
    let canvas = area(200.0, 200.0, 300.0, 300.0);
    assert_eq!((picture.colours(canvas), picture.lit(canvas, 30)), (1, 1.0));
    let ground = area(400.0, 200.0, 600.0, 400.0);
    assert_eq!((picture.colours(ground), picture.lit(ground, 30)), (1, 0.0));
    assert_eq!(page.errors(), Vec::<String>::new());

    page.evaluate("console.error('something broke')");
    assert_eq!(page.errors().len(), 1);
}
