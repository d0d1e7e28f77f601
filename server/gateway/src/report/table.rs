//! Tables.

use super::html::Html;
use std::io;

/// A column: its name, and the class of its cells. `n` are numbers, to the right; `t` are short texts that are not broken.
pub(super) type Column = (&'static str, &'static str);

/// What stands in a cell.
pub(super) enum Cell<'a> {
    Text(&'a str),
    /// It needs attention.
    Alert(&'a str),
    /// It leads to the section of the run of this number in the report.
    Run(usize, &'a str),
}

/// A table that is written row by row.
pub(super) struct Table<'h, 'w> {
    html: &'h mut Html<'w>,
    columns: &'h [Column],
}

impl<'h, 'w> Table<'h, 'w> {
    /// Begins a table of a class with the names of its columns.
    pub(super) fn begin(
        html: &'h mut Html<'w>,
        class: &'static str,
        columns: &'h [Column],
    ) -> io::Result<Self> {
        html.open("table", class)?;
        html.markup("<thead><tr>")?;
        for (name, class) in columns {
            html.element("th", class, name)?;
        }
        html.markup("</tr></thead>\n<tbody>\n")?;
        Ok(Self { html, columns })
    }

    /// Writes a row.
    pub(super) fn row(&mut self, cells: &[Cell<'_>]) -> io::Result<()> {
        self.html.markup("<tr>")?;
        for ((_, class), cell) in self.columns.iter().zip(cells) {
            self.html.open("td", class)?;
            match cell {
                Cell::Text(text) => self.html.text(text)?,
                Cell::Alert(text) => self.html.element("span", "alert", text)?,
                Cell::Run(number, text) => {
                    self.html.markup("<a href=\"#run-")?;
                    self.html.text(&number.to_string())?;
                    self.html.markup("\">")?;
                    self.html.text(text)?;
                    self.html.markup("</a>")?;
                }
            }
            self.html.close("td")?;
        }
        self.html.close("tr")
    }

    /// Ends the table.
    pub(super) fn end(self) -> io::Result<()> {
        self.html.markup("</tbody>\n</table>\n")
    }
}
