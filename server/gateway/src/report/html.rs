//! Writes HTML. Markup is constant text of this program. Everything else comes from people, robots and files, and is escaped.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::io::{self, Read, Write};

/// Bytes of a file that are encoded at a time. A multiple of three, so that only the last piece is padded.
const PIECE_BYTES: u64 = 3 << 14;

/// A document that is written from its beginning to its end.
pub(super) struct Html<'w> {
    sink: &'w mut dyn Write,
}

impl<'w> Html<'w> {
    /// Writes to `sink`.
    pub(super) fn new(sink: &'w mut dyn Write) -> Self {
        Self { sink }
    }

    /// Writes markup as it is.
    pub(super) fn markup(&mut self, markup: &'static str) -> io::Result<()> {
        self.sink.write_all(markup.as_bytes())
    }

    /// Writes text, or the value of an attribute in double quotes.
    pub(super) fn text(&mut self, text: &str) -> io::Result<()> {
        let mut written = 0;
        for (at, letter) in text.char_indices() {
            let Some(replacement) = replacement(letter) else { continue };
            self.sink.write_all(&text.as_bytes()[written..at])?;
            self.sink.write_all(replacement.as_bytes())?;
            written = at + letter.len_utf8();
        }
        self.sink.write_all(&text.as_bytes()[written..])
    }

    /// Writes an element of a class that holds this text.
    pub(super) fn element(&mut self, tag: &'static str, class: &'static str, text: &str) -> io::Result<()> {
        self.open(tag, class)?;
        self.text(text)?;
        self.close(tag)
    }

    /// Begins an element of a class; an empty one is left out.
    pub(super) fn open(&mut self, tag: &'static str, class: &'static str) -> io::Result<()> {
        self.markup("<")?;
        self.markup(tag)?;
        if !class.is_empty() {
            self.markup(" class=\"")?;
            self.markup(class)?;
            self.markup("\"")?;
        }
        self.markup(">")
    }

    /// Ends an element.
    pub(super) fn close(&mut self, tag: &'static str) -> io::Result<()> {
        self.markup("</")?;
        self.markup(tag)?;
        self.markup(">\n")
    }

    /// Writes the bytes of a file as a `data:` address of this type. Memory holds a piece of it.
    pub(super) fn data_address(
        &mut self,
        media_type: &'static str,
        mut content: impl Read,
    ) -> io::Result<()> {
        self.markup("data:")?;
        self.markup(media_type)?;
        self.markup(";base64,")?;
        let (mut piece, mut encoded) = (Vec::new(), String::new());
        loop {
            piece.clear();
            encoded.clear();
            content.by_ref().take(PIECE_BYTES).read_to_end(&mut piece)?;
            STANDARD.encode_string(&piece, &mut encoded);
            self.sink.write_all(encoded.as_bytes())?;
            if (piece.len() as u64) < PIECE_BYTES {
                return Ok(());
            }
        }
    }
}

/// What is written in place of a letter; none: the letter itself. Letters that cannot be seen, and those that turn the direction of writing, are replaced
/// too, so that a name does not read as another one.
fn replacement(letter: char) -> Option<&'static str> {
    match letter {
        '&' => Some("&amp;"),
        '<' => Some("&lt;"),
        '>' => Some("&gt;"),
        '"' => Some("&quot;"),
        '\'' => Some("&#39;"),
        '\n' | '\t' => None,
        '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => Some("\u{fffd}"),
        letter if letter.is_control() => Some("\u{fffd}"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(write: impl FnOnce(&mut Html<'_>) -> io::Result<()>) -> String {
        let mut bytes = Vec::new();
        write(&mut Html::new(&mut bytes)).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn text_cannot_become_markup_or_leave_an_attribute() {
        let hostile = "a<script>alert('1')</script>&\"b\u{0}\u{202e}\nµ";
        let escaped =
            "a&lt;script&gt;alert(&#39;1&#39;)&lt;/script&gt;&amp;&quot;b\u{fffd}\u{fffd}\nµ".to_owned();
        assert_eq!(written(|html| html.text(hostile)), escaped);
        assert_eq!(
            written(|html| html.element("p", "why", hostile)),
            format!("<p class=\"why\">{escaped}</p>\n")
        );
    }

    #[test]
    fn a_file_is_written_as_base64_with_its_padding() {
        let address = written(|html| html.data_address("image/png", &b"photo\xff\x00"[..]));
        assert_eq!(address, "data:image/png;base64,cGhvdG//AA==");
    }

    /// Takes and gives a few bytes at a time, as sockets and files may.
    struct Few<T>(T);

    impl Write for Few<Vec<u8>> {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.write(&bytes[..bytes.len().min(7)])
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Read for Few<&[u8]> {
        fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
            let room = bytes.len().min(5);
            self.0.read(&mut bytes[..room])
        }
    }

    #[test]
    fn a_long_file_arrives_whole_where_a_few_bytes_are_taken_at_a_time() {
        for bytes in [0, 1, PIECE_BYTES - 1, PIECE_BYTES, PIECE_BYTES + 1, 3 * PIECE_BYTES] {
            let content: Vec<u8> = (0..bytes).map(|number| (number % 251) as u8).collect();
            let mut sink = Few(Vec::new());
            Html::new(&mut sink).data_address("image/png", Few(&content[..])).unwrap();
            let text = String::from_utf8(sink.0).unwrap();
            let encoded = text.strip_prefix("data:image/png;base64,").unwrap();
            assert!(STANDARD.decode(encoded).is_ok_and(|decoded| decoded == content), "{bytes} bytes");
        }
    }
}
