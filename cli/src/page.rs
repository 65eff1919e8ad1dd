//! A page that shows itself everywhere: one file of HTML without scripts, in the colours of the reader.

use std::fmt::{Display, Write};

use base64::{Engine, prelude::BASE64_STANDARD};

use crate::{chart, picture::Picture};

const STYLE: &str = "\
:root{color-scheme:light dark;--ink:#222;--soft:#6b6b70;--paper:#fdfdfc;--panel:#f2f2ef;--line:#ddd;--bar:#3b6ea5;--warn:#b3261e}\
@media(prefers-color-scheme:dark){:root{--ink:#ddd;--soft:#96969c;--paper:#161618;--panel:#202024;--line:#34343a;--bar:#6fa3d8;--warn:#ff8a80}}\
body{font:15px/1.5 system-ui,sans-serif;max-width:70rem;margin:2rem auto;padding:0 1rem;color:var(--ink);background:var(--paper)}\
h1{font-size:1.6rem;margin-bottom:.2rem}h2{font-size:1.15rem;margin:2.2rem 0 .6rem;border-bottom:1px solid var(--line);padding-bottom:.2rem}\
p{max-width:52rem}p.soft,figcaption,th{color:var(--soft)}p.warn{color:var(--warn);font-weight:600}\
img{max-width:100%;height:auto;background:#000}svg{max-width:100%;height:auto}\
code{font:13px/1.4 ui-monospace,monospace;overflow-wrap:anywhere}\
table{border-collapse:collapse}td,th{padding:.12rem 1rem .12rem 0;text-align:left;font-weight:normal;vertical-align:baseline}\
thead th{border-bottom:1px solid var(--line)}td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}\
.bar{display:inline-block;height:.7rem;background:var(--bar);vertical-align:middle}\
.cards{display:grid;grid-template-columns:repeat(auto-fill,minmax(14rem,1fr));gap:.6rem;margin:1rem 0}\
.cards div{background:var(--panel);border-radius:.4rem;padding:.55rem .8rem}\
.cards b{display:block;font-size:1.25rem;font-weight:600;font-variant-numeric:tabular-nums}.cards span{color:var(--soft);font-size:.82rem}\
.beside{display:flex;flex-wrap:wrap;gap:1.6rem;align-items:flex-start}.beside>.rest{flex:1 1 28rem}.rest h2{margin-top:0}\
.maps{display:flex;flex-wrap:wrap;gap:1.2rem 1.6rem}figure{margin:0}figure.map{width:max-content;max-width:100%}\
.map svg{display:block;margin:.25rem 0}.map .dead{fill:var(--line)}.map p.mean{margin:0;font-size:.8rem;color:var(--soft)}\
.scale{display:flex;gap:.4rem;align-items:center;font-size:.75rem;color:var(--soft)}.scale i{display:block;flex:1;min-width:3rem;height:.5rem}\
.split{display:flex;height:2.1rem;border-radius:.3rem;overflow:hidden;margin:.6rem 0}.split i{display:block}\
.key{display:inline-block;width:.8rem;height:.8rem;border-radius:.15rem;vertical-align:-.08rem;margin-right:.45rem}\
details{margin:.6rem 0}summary{cursor:pointer;color:var(--soft)}";

/// A page that is being written.
#[derive(Debug)]
pub(crate) struct Page(String);

/// A row with a bar.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Bar {
    pub(crate) name: String,
    pub(crate) text: String,
    pub(crate) value: f64,
}

impl Bar {
    pub(crate) fn new(name: impl Into<String>, text: impl Display, value: f64) -> Self {
        Self { name: name.into(), text: text.to_string(), value }
    }
}

// Writing to a string does not fail: the results are dropped.
impl Page {
    /// Begins a page.
    pub(crate) fn new(title: &str) -> Self {
        let title = escaped(title);
        Self(format!(
            "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\">\
             <meta name=\"viewport\" content=\"width=device-width\">\
             <title>{title} - Kiloray</title>\n<style>{STYLE}</style>\n<h1>{title}</h1>\n"
        ))
    }

    /// The page.
    pub(crate) fn finish(self) -> String {
        self.0
    }

    /// HTML as it is.
    pub(crate) fn raw(&mut self, html: &str) {
        self.0.push_str(html);
    }

    /// A heading.
    pub(crate) fn heading(&mut self, text: &str) {
        let _ = writeln!(self.0, "<h2>{}</h2>", escaped(text));
    }

    /// A paragraph.
    pub(crate) fn text(&mut self, text: impl Display) {
        let _ = writeln!(self.0, "<p>{}", escaped(&text.to_string()));
    }

    /// A paragraph that explains.
    pub(crate) fn soft(&mut self, text: impl Display) {
        let _ = writeln!(self.0, "<p class=\"soft\">{}", escaped(&text.to_string()));
    }

    /// A paragraph that warns.
    pub(crate) fn warning(&mut self, text: impl Display) {
        let _ = writeln!(self.0, "<p class=\"warn\">{}", escaped(&text.to_string()));
    }

    /// Figures that come first.
    pub(crate) fn cards(&mut self, cards: &[(&str, String)]) {
        self.raw("<div class=\"cards\">");
        for (name, value) in cards {
            let _ = write!(self.0, "<div><b>{}</b><span>{name}</span></div>", escaped(value));
        }
        self.raw("</div>\n");
    }

    /// A picture of bytes of a PNG file.
    pub(crate) fn picture(&mut self, picture: &Picture, png: &[u8]) {
        let _ = writeln!(
            self.0,
            "<img alt=\"The picture\" width=\"{}\" height=\"{}\" src=\"data:image/png;base64,{}\">",
            picture.width,
            picture.height,
            BASE64_STANDARD.encode(png),
        );
    }

    /// Names and values.
    pub(crate) fn pairs(&mut self, rows: &[(&str, String)]) {
        self.raw("<table>");
        for (name, value) in rows {
            let _ = writeln!(self.0, "<tr><th>{name}<td>{}", escaped(value));
        }
        self.raw("</table>\n");
    }

    /// Rows under heads. All but the first column are numbers.
    pub(crate) fn table(&mut self, heads: &[&str], rows: &[Vec<String>]) {
        self.raw("<table><thead><tr>");
        for (i, head) in heads.iter().enumerate() {
            let class = if i > 0 { " class=\"n\"" } else { "" };
            let _ = write!(self.0, "<th{class}>{}", escaped(head));
        }
        self.raw("<tbody>\n");
        for row in rows {
            self.raw("<tr>");
            for (i, value) in row.iter().enumerate() {
                let tag = if i == 0 { "th" } else { "td class=\"n\"" };
                let _ = write!(self.0, "<{tag}>{}", escaped(value));
            }
            self.raw("\n");
        }
        self.raw("</table>\n");
    }

    /// Rows with bars, the longest as long as can be.
    pub(crate) fn bars(&mut self, rows: &[Bar]) {
        let most = rows.iter().map(|row| row.value).fold(0.0, f64::max);
        self.raw("<table>");
        for row in rows {
            let width = if most > 0.0 { 20.0 * row.value.max(0.0) / most } else { 0.0 };
            let _ = writeln!(
                self.0,
                "<tr><th>{}<td class=\"n\">{}<td><span class=\"bar\" style=\"width:{width:.2}rem\"></span>",
                escaped(&row.name),
                escaped(&row.text),
            );
        }
        self.raw("</table>\n");
    }

    /// A whole split in parts, as one bar with a key.
    pub(crate) fn split(&mut self, parts: &[(String, String, f64)]) {
        let shown: Vec<_> = parts.iter().filter(|part| part.2 >= 0.000_5).collect();
        self.raw("<div class=\"split\">");
        for (i, (name, text, part)) in shown.iter().enumerate() {
            let _ = write!(
                self.0,
                "<i style=\"width:{:.2}%;background:{}\" title=\"{}: {}\"></i>",
                100.0 * part,
                colour(i),
                escaped(name),
                escaped(text)
            );
        }
        self.raw("</div>\n<table>");
        for (i, (name, text, _)) in shown.iter().enumerate() {
            let _ = writeln!(
                self.0,
                "<tr><th><i class=\"key\" style=\"background:{}\"></i>{}<td class=\"n\">{}",
                colour(i),
                escaped(name),
                escaped(text)
            );
        }
        self.raw("</table>\n");
    }
}

/// Of the parts of a whole: green is what was wanted.
fn colour(part: usize) -> String {
    const ORDER: [usize; 8] = [2, 1, 0, 3, 5, 4, 7, 6];
    match ORDER.get(part) {
        Some(&i) => chart::css(chart::SERIES[i]),
        None => "#888".into(),
    }
}

/// Text as HTML.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_typed_cannot_break_the_page() {
        let mut page = Page::new("<script>");
        page.text("a < b & \"c\"");
        page.table(&["<i>", "n"], &[vec!["<b>".into(), "1".into()]]);
        page.bars(&[Bar::new("<u>", "<s>", f64::NAN)]);
        page.split(&[("<p>".into(), "<q>".into(), 0.5)]);
        let html = page.finish();
        for tag in ["<script>", "<i>", "<b>", "<u>", "<s>", "<q>", "\"c\""] {
            assert!(!html.contains(tag), "{tag}");
        }
    }
}
