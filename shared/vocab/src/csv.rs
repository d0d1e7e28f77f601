//! Fields of comma-separated values (RFC 4180).

/// A field of text in quotes. Spreadsheets take a field that begins with one of `= + - @`, a tab or a carriage return for a formula, so an apostrophe goes before it. The text may
/// be from outside.
pub fn csv_field(text: &str) -> String {
    let guard = if text.starts_with(['=', '+', '-', '@', '\t', '\r']) { "'" } else { "" };
    format!("\"{guard}{}\"", text.replace('"', "\"\""))
}

#[cfg(test)]
mod tests {
    use super::csv_field;

    #[test]
    fn no_field_is_a_formula_or_breaks_its_row() {
        assert_eq!(csv_field("=HYPERLINK(\"x\")"), "\"'=HYPERLINK(\"\"x\"\")\"");
        assert_eq!(csv_field("a, b\r\n"), "\"a, b\r\n\"");
    }
}
