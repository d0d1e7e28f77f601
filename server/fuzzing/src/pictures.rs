//! Pictures.

use crate::assert_sentence;

/// `formats::picture`: JPEG, PNG and BMP.
pub fn picture(bytes: &[u8]) {
    match formats::picture::read(bytes) {
        Err(error) => assert_sentence(&error),
        Ok(picture) => {
            let [width, height] = picture.size_px;
            assert!(width > 0 && height > 0 && picture.pixels.len() == width * height);
        }
    }
}
