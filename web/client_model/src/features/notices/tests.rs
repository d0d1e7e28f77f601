//! Which notices are shown, and how long.

use crate::testing::*;
use crate::*;
use api::ServerMessage;
use vocab::Stamp;

#[test]
fn a_notice_from_before_is_no_news_when_the_snapshot_repeats_it() {
    let mut client = TestClient::connected();
    for (secs, text) in [(100.0, "old"), (4999.0, "new")] {
        let at = Stamp::from_secs_f64(secs);
        client.event(api::Event::Notice(api::Notice {
            at,
            severity: api::Severity::Info,
            text: text.into(),
        }));
    }
    assert!(client.model.notices().visible().is_empty(), "nobody knows yet how old they are");
    client.server(ServerMessage::Pong { token: 1, now: Stamp::from_secs_f64(5000.0) });
    let shown: Vec<&str> =
        client.model.notices().visible().iter().map(|notice| notice.text.as_str()).collect();
    assert_eq!(shown, ["new"]);
}

#[test]
fn errors_stay_until_they_are_put_away_and_the_rest_goes_by_itself() {
    let mut client = TestClient::connected();
    client.server(ServerMessage::Pong { token: 1, now: Stamp::EPOCH });
    for (severity, text) in [(api::Severity::Info, "saved"), (api::Severity::Error, "LiDAR silent")] {
        let notice = api::Notice { at: Stamp::EPOCH, severity, text: text.into() };
        client.event(api::Event::Notice(notice));
    }
    for _ in 0..30 {
        client.wait(1.0);
        client.server(ServerMessage::Pong { token: 0, now: Stamp::EPOCH });
    }
    let left: Vec<&str> =
        client.model.notices().visible().iter().map(|notice| notice.text.as_str()).collect();
    assert_eq!(left, ["LiDAR silent"]);
    let id = client.model.notices().visible()[0].id;
    client.command(ClientCommand::DismissNotice(id));
    assert!(client.model.notices().visible().is_empty());
}
