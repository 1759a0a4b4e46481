//! PDF for the workshop: an overview, the board at 1:1 on as many pages as it takes, and the tables.
//!
//! The pages of the board have a frame with crosses at its corners: cut along it, the pages lie edge to edge. Each says
//! its column and row, and has a bar of 100 mm to check the printer's scale. Pages without any part of the harness are
//! left out; the overview shows which there are.

use super::scene::{Anchor, Layer, Shape, scene};
use super::{Drawing, Table};
use crate::line::{Line, Point};
use pdf_writer::types::LineCapStyle;
use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, Str};
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::ops::Range;

/// Sizes of paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paper {
    /// 841 mm × 1189 mm.
    A0,
    /// 594 mm × 841 mm.
    A1,
    /// 420 mm × 594 mm.
    A2,
    /// 297 mm × 420 mm.
    A3,
    /// 210 mm × 297 mm.
    A4,
}

impl Paper {
    /// The short and the long side, mm.
    pub fn size(self) -> [f64; 2] {
        match self {
            Paper::A0 => [841.0, 1189.0],
            Paper::A1 => [594.0, 841.0],
            Paper::A2 => [420.0, 594.0],
            Paper::A3 => [297.0, 420.0],
            Paper::A4 => [210.0, 297.0],
        }
    }
}

/// Points of PDF for each mm.
const POINTS: f64 = 72.0 / 25.4;
/// Border of a page, mm, on which most printers print.
const BORDER: f64 = 10.0;
/// Length of the scale bar, mm.
const BAR: f64 = 100.0;
/// Text in tables and borders, mm.
const TEXT: f64 = 2.4;
/// Height of a row of a table, mm.
const ROW: f64 = 4.6;
const FONT: Name<'static> = Name(b"F1");
const BOLD: Name<'static> = Name(b"F2");

/// The drawing as the bytes of a PDF file.
pub fn pdf(drawing: &Drawing<'_>, paper: Paper) -> Vec<u8> {
    let shapes = scene(drawing);
    let tiles = Tiles::of(drawing, paper, &shapes);
    let mut pages = vec![overview(drawing, &shapes, &tiles)];
    pages.extend(tiles.used.iter().map(|own| tile(drawing, &shapes, &tiles, own)));
    pages.extend(drawing.tables.iter().flat_map(|table| table_pages(drawing.title, table)));
    assemble(&pages)
}

/// Characters of a drawing that the fonts of PDF do not have; `?` stands for them.
pub fn not_printable(drawing: &Drawing<'_>) -> Vec<char> {
    let in_shapes = scene(drawing).into_iter().map(|(_, shape)| match shape {
        Shape::Text { text, .. } | Shape::Dimension { text, .. } => text,
        _ => String::new(),
    });
    let in_tables = drawing.tables.iter().flat_map(|table| {
        let cells = table.rows.iter().flatten().chain(&table.columns).chain([&table.title]);
        cells.cloned().collect::<Vec<String>>()
    });
    let texts: Vec<String> = in_shapes.chain(in_tables).collect();
    let mut all: Vec<char> = texts.iter().flat_map(|text| text.chars()).filter(|c| code(*c).is_none()).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// A page: its size, mm, and what is on it.
struct Page {
    size: [f64; 2],
    content: Content,
}

impl Page {
    /// A page with lengths in mm from its lower left corner.
    fn new(size: [f64; 2]) -> Self {
        let mut content = Content::new();
        let scale = POINTS as f32;
        content.transform([scale, 0.0, 0.0, scale, 0.0, 0.0]);
        Self { size, content }
    }

    fn text(&mut self, at: Point, height: f64, anchor: Anchor, text: &str) {
        write_text(&mut self.content, FONT, at, height, 0.0, anchor, text);
    }
}

/// The pages of a board.
struct Tiles {
    /// Size of the paper as it lies, mm.
    paper: [f64; 2],
    /// Part of the board on a page, mm.
    step: [f64; 2],
    columns: usize,
    rows: usize,
    /// Those that have something of the harness, from the upper left.
    used: Vec<Tile>,
}

/// A page of a board.
struct Tile {
    /// Both from 0; row 0 is the lowest.
    column: usize,
    row: usize,
    /// What is on it of the harness, by index.
    shapes: Vec<usize>,
}

impl Tiles {
    /// Upright or on its side, whichever takes fewer pages.
    fn of(drawing: &Drawing<'_>, paper: Paper, shapes: &[(Layer, Shape)]) -> Self {
        let [short, long] = paper.size();
        let [side, upright] = [[long, short], [short, long]].map(|paper| Self::on(paper, drawing, shapes));
        if side.used.len() <= upright.used.len() { side } else { upright }
    }

    /// On paper that lies so, mm.
    fn on(paper: [f64; 2], drawing: &Drawing<'_>, shapes: &[(Layer, Shape)]) -> Self {
        let step = paper.map(|x| x - 2.0 * BORDER);
        let count = |k: usize| ((drawing.board.size[k] * 1e3 / step[k]) - 1e-9).ceil().max(1.0) as usize;
        let mut tiles = Self { paper, step, columns: count(0), rows: count(1), used: Vec::new() };
        let mut used: BTreeMap<(Reverse<usize>, usize), Vec<usize>> = BTreeMap::new();
        for (k, (_, shape)) in shapes.iter().enumerate().filter(|(_, (layer, _))| !layer.is_background()) {
            for own in boxes(shape, &step) {
                let [columns, rows] = tiles.within(&own);
                for (row, column) in rows.flat_map(|row| columns.clone().map(move |column| (row, column))) {
                    let on_page = used.entry((Reverse(row), column)).or_default();
                    if on_page.last() != Some(&k) {
                        on_page.push(k);
                    }
                }
            }
        }
        tiles.used = used.into_iter().map(|((Reverse(row), column), shapes)| Tile { column, row, shapes }).collect();
        tiles
    }

    /// The columns and rows of the pages that a box is on.
    fn within(&self, [low, high]: &[Point; 2]) -> [Range<usize>; 2] {
        [0, 1].map(|k| {
            let count = [self.columns, self.rows][k];
            let page = |x: f64| (x / self.step[k]).floor();
            // Conversions saturate: what lies left of the board ends before its first page.
            page(low[k]).max(0.0) as usize..((page(high[k]) + 1.0) as usize).min(count)
        })
    }

    /// The part of the board on a page, mm.
    fn part(&self, column: usize, row: usize) -> [Point; 2] {
        let corner = Point::new(column as f64 * self.step[0], row as f64 * self.step[1]);
        [corner, corner + Point::new(self.step[0], self.step[1])]
    }
}

fn overlap(a: &[Point; 2], b: &[Point; 2]) -> bool {
    a[0].x <= b[1].x && b[0].x <= a[1].x && a[0].y <= b[1].y && b[0].y <= a[1].y
}

/// Boxes around a shape, mm. A long line has several, each around a part that is no longer than a page.
fn boxes(shape: &Shape, page: &[f64; 2]) -> Vec<[Point; 2]> {
    let around = |[low, high]: [Point; 2], more: f64| [low - Point::repeat(more), high + Point::repeat(more)];
    let along = |line: &Line, more: f64| {
        let parts = (line.length / page[0].min(page[1])).ceil().max(1.0) as usize;
        line.divided(parts).map(|part| around(part.extent(), more)).collect()
    };
    match shape {
        Shape::Cable { line, width } => along(line, 0.5 * width),
        Shape::Segment(a, b) => {
            let d = b - a;
            along(&Line { start: *a, direction: d.y.atan2(d.x), curvature: 0.0, length: d.norm() }, 0.0)
        }
        Shape::Circle { centre, radius } => vec![around([*centre; 2], *radius)],
        Shape::Polygon(points) => {
            let first = points.first().copied().unwrap_or_default();
            vec![points.iter().fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)])]
        }
        Shape::Text { at, height, turn, anchor, text } => {
            let [left, right] = anchor.reach(width_of(text, *height)).map(|x| at + crate::line::unit(*turn) * x);
            vec![around([left.inf(&right), left.sup(&right)], *height)]
        }
        Shape::Dimension { .. } => shape.dimension_parts().iter().flat_map(|part| boxes(part, page)).collect(),
    }
}

/// The board on a page A4, with the pages at 1:1.
fn overview(drawing: &Drawing<'_>, shapes: &[(Layer, Shape)], tiles: &Tiles) -> Page {
    let [short, long] = Paper::A4.size();
    let mut page = Page::new([long, short]);
    let [width, height] = drawing.board.size.map(|x| x * 1e3);
    let room = [long - 2.0 * BORDER, short - 2.0 * BORDER - 20.0];
    let scale = (room[0] / width).min(room[1] / height).min(1.0);
    let bottom = BORDER + 10.0 + 0.5 * (room[1] - scale * height);
    page.text(Point::new(BORDER, short - BORDER - 4.0), 4.0, Anchor::Left, drawing.title);
    let used = tiles.used.len();
    let pages = if used == 1 { "page" } else { "pages" };
    let about = format!(
        "overview 1:{:.1}; board {:.0} mm x {:.0} mm at 1:1 on the next {used} {pages}, {:.0} mm x {:.0} mm of it on \
         each",
        1.0 / scale,
        width,
        height,
        tiles.step[0],
        tiles.step[1]
    );
    page.text(Point::new(BORDER, short - BORDER - 9.0), TEXT, Anchor::Left, &about);
    let content = &mut page.content;
    content.save_state();
    content.transform([scale as f32, 0.0, 0.0, scale as f32, BORDER as f32, bottom as f32]);
    for (layer, shape) in shapes {
        if matches!(layer, Layer::Board | Layer::Cables | Layer::Ends) {
            draw(content, *layer, shape, 0.2 / scale);
        }
    }
    content.set_stroke_rgb(0.8, 0.2, 0.2).set_fill_rgb(0.8, 0.2, 0.2).set_line_width((0.15 / scale) as f32);
    for &Tile { column, row, .. } in &tiles.used {
        let [low, high] = tiles.part(column, row);
        content.rect(low.x as f32, low.y as f32, (high.x - low.x) as f32, (high.y - low.y) as f32).stroke();
        let at = low + Point::repeat(1.0 / scale);
        let height = (2.0 / scale).min(0.3 * tiles.step[1]);
        write_text(content, FONT, at, height, 0.0, Anchor::Left, &name(column, row));
    }
    content.restore_state();
    bar(&mut page, Point::new(BORDER, BORDER), scale);
    page
}

/// Name of a page of the board: column and row from 1.
fn name(column: usize, row: usize) -> String {
    format!("{}-{}", column + 1, row + 1)
}

/// A bar of 100 mm on the board, or less where that would be longer than a third of an overview.
fn bar(page: &mut Page, at: Point, scale: f64) {
    let lengths = [BAR, 500.0, 1000.0, 5000.0, 10_000.0, 50_000.0, 100_000.0];
    // As near to 80 mm on paper as may be.
    let off = |length: &f64| (length * scale / 80.0).ln().abs();
    let length = if scale == 1.0 { Some(BAR) } else { lengths.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))) };
    let length = length.unwrap_or(BAR);
    let content = &mut page.content;
    content.set_stroke_gray(0.0).set_fill_gray(0.0).set_line_width(0.2);
    let part = length * scale / 10.0;
    for k in 0..10_u8 {
        let x = at.x + f64::from(k) * part;
        content.rect(x as f32, at.y as f32, part as f32, 1.5);
        if k % 2 == 0 {
            content.fill_nonzero_and_stroke()
        } else {
            content.stroke()
        };
    }
    page.text(at + Point::new(length * scale + 2.0, 0.0), TEXT, Anchor::Left, &format!("{length:.0} mm"));
}

/// A page of the board at 1:1.
fn tile(drawing: &Drawing<'_>, shapes: &[(Layer, Shape)], tiles: &Tiles, tile: &Tile) -> Page {
    let &Tile { column, row, .. } = tile;
    let mut page = Page::new(tiles.paper);
    let part = tiles.part(column, row);
    let [width, height] = tiles.step;
    let content = &mut page.content;
    content.save_state();
    let border = BORDER as f32;
    content.rect(border, border, width as f32, height as f32).clip_nonzero().end_path();
    content.transform([1.0, 0.0, 0.0, 1.0, (BORDER - part[0].x) as f32, (BORDER - part[0].y) as f32]);
    let is_here = |shape: &Shape| boxes(shape, &tiles.step).iter().any(|own| overlap(own, &part));
    let background = shapes.iter().filter(|(layer, shape)| layer.is_background() && is_here(shape));
    for (layer, shape) in background.chain(tile.shapes.iter().map(|&k| &shapes[k])) {
        draw(content, *layer, shape, 0.25);
    }
    content.restore_state();
    content.set_stroke_gray(0.0).set_line_width(0.15);
    for (x, y) in [(0.0, 0.0), (width, 0.0), (0.0, height), (width, height)] {
        let (x, y) = ((BORDER + x) as f32, (BORDER + y) as f32);
        content.move_to(x - 5.0, y).line_to(x + 5.0, y).move_to(x, y - 5.0).line_to(x, y + 5.0).stroke();
    }
    let above = BORDER + height + 3.0;
    let about = format!(
        "{}: page {} of {} columns and {} rows, 1:1; x from {:.0} mm, y from {:.0} mm",
        drawing.title,
        name(column, row),
        tiles.columns,
        tiles.rows,
        part[0].x,
        part[0].y
    );
    page.text(Point::new(BORDER + 8.0, above), TEXT, Anchor::Left, &about);
    bar(&mut page, Point::new(BORDER + 8.0, 3.0), 1.0);
    page
}

/// Draws a shape in mm.
fn draw(content: &mut Content, layer: Layer, shape: &Shape, thin: f64) {
    let [r, g, b] = layer.colour().map(|part| f32::from(part) / 255.0);
    content.set_stroke_rgb(r, g, b).set_fill_rgb(r, g, b).set_line_width(thin as f32);
    match shape {
        Shape::Cable { line, width } => {
            content.set_line_width(width.max(thin) as f32).set_line_cap(LineCapStyle::RoundCap);
            path(content, line);
            content.stroke().set_line_cap(LineCapStyle::ButtCap);
        }
        Shape::Segment(a, b) => {
            content.move_to(a.x as f32, a.y as f32).line_to(b.x as f32, b.y as f32).stroke();
        }
        Shape::Circle { centre, radius } => {
            let around = |direction: f64| Line {
                start: centre - Point::new(0.0, radius.copysign(direction)),
                direction: if direction > 0.0 { 0.0 } else { std::f64::consts::PI },
                curvature: 1.0 / radius,
                length: std::f64::consts::PI * radius,
            };
            path(content, &around(1.0));
            path(content, &around(-1.0));
            content.stroke();
        }
        Shape::Polygon(points) => {
            for (k, p) in points.iter().enumerate() {
                let (x, y) = (p.x as f32, p.y as f32);
                if k == 0 {
                    content.move_to(x, y)
                } else {
                    content.line_to(x, y)
                };
            }
            content.close_and_stroke();
        }
        Shape::Text { at, height, turn, anchor, text } => {
            write_text(content, FONT, *at, *height, *turn, *anchor, text);
        }
        Shape::Dimension { .. } => {
            shape.dimension_parts().iter().for_each(|part| draw(content, layer, part, thin));
        }
    }
}

/// A line as cubic curves of at most 30°: their control points lie `4/3 tan(α/4)` radii along the tangents, 10⁻⁸ of
/// the radius off the circle.
fn path(content: &mut Content, line: &Line) {
    content.move_to(line.start.x as f32, line.start.y as f32);
    if line.curvature == 0.0 {
        let end = line.end();
        content.line_to(end.x as f32, end.y as f32);
        return;
    }
    let turn = line.curvature * line.length;
    let parts = (turn.abs().to_degrees() / 30.0).ceil().max(1.0);
    let handle = 4.0 / 3.0 * (turn.abs() / parts / 4.0).tan() / line.curvature.abs();
    for k in 0..parts as usize {
        let [a, b] = [k, k + 1].map(|k| line.length * k as f64 / parts);
        let (from, to) = (line.at(a), line.at(b));
        let first = from + crate::line::unit(line.direction_at(a)) * handle;
        let second = to - crate::line::unit(line.direction_at(b)) * handle;
        let [x1, y1, x2, y2, x3, y3] = [first.x, first.y, second.x, second.y, to.x, to.y].map(|x| x as f32);
        content.cubic_to(x1, y1, x2, y2, x3, y3);
    }
}

/// `height`: that of capitals, 0.72 of the size of Helvetica.
fn write_text(content: &mut Content, font: Name<'_>, at: Point, height: f64, turn: f64, anchor: Anchor, text: &str) {
    let [left, _] = anchor.reach(width_of(text, height));
    let (sine, cosine) = turn.sin_cos();
    let (x, y) = (at.x + left * cosine, at.y + left * sine);
    content.begin_text().set_font(font, (height / 0.72) as f32);
    content.set_text_matrix([cosine as f32, sine as f32, -sine as f32, cosine as f32, x as f32, y as f32]);
    content.show(Str(&encoded(text))).end_text();
}

/// Width of a text in Helvetica, mm; that of letters is a mean, digits and signs have their own.
fn width_of(text: &str, height: f64) -> f64 {
    let width = |c: char| match c {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | ' ' | '/' | '\'' | 'I' | '|' | '!' => 0.27,
        '-' | '(' | ')' | 'f' | 't' | 'r' => 0.33,
        'm' | 'M' | 'W' | 'w' => 0.83,
        c if c.is_uppercase() => 0.69,
        _ => 0.556,
    };
    text.chars().map(width).sum::<f64>() * height / 0.72
}

/// Bytes of a text in WinAnsiEncoding; `?` stands for characters that it does not have.
fn encoded(text: &str) -> Vec<u8> {
    text.chars().map(|c| code(c).unwrap_or(b'?')).collect()
}

/// The code of a character in WinAnsiEncoding.
fn code(c: char) -> Option<u8> {
    const OTHERS: [(char, u8); 8] =
        [('€', 0x80), ('‚', 0x82), ('„', 0x84), ('…', 0x85), ('‘', 0x91), ('’', 0x92), ('–', 0x96), ('—', 0x97)];
    match c {
        ' '..='~' | '\u{a0}'..='\u{ff}' => u8::try_from(u32::from(c)).ok(),
        _ => OTHERS.iter().find(|(own, _)| *own == c).map(|(_, code)| *code),
    }
}

/// A table on as many pages A4 as it takes.
fn table_pages(title: &str, table: &Table) -> Vec<Page> {
    let size = Paper::A4.size();
    let [width, height] = size;
    let per_page = ((height - 2.0 * BORDER - 14.0) / ROW).floor() as usize - 1;
    let count = table.rows.len().div_ceil(per_page).max(1);
    let columns = columns(table, width - 2.0 * BORDER);
    let mut pages = Vec::new();
    for k in 0..count {
        let mut page = Page::new(size);
        let mut y = height - BORDER - 4.0;
        let of = if count > 1 { format!(" ({} of {count})", k + 1) } else { String::new() };
        let headline = format!("{}{of}", table.title);
        write_text(&mut page.content, BOLD, Point::new(BORDER, y), 3.5, 0.0, Anchor::Left, &headline);
        page.text(Point::new(width - BORDER, y), TEXT, Anchor::Right, title);
        y -= 8.0;
        row(&mut page, BOLD, y, &columns, &table.columns.iter().map(|own| plain(own)).collect::<Vec<_>>());
        page.content.set_stroke_gray(0.5).set_line_width(0.2);
        let under = (y - 1.4) as f32;
        page.content.move_to(BORDER as f32, under).line_to((width - BORDER) as f32, under).stroke();
        for cells in table.rows.iter().skip(k * per_page).take(per_page) {
            y -= ROW;
            row(&mut page, FONT, y, &columns, &cells.iter().map(String::as_str).collect::<Vec<_>>());
        }
        pages.push(page);
    }
    pages
}

/// A column: where it begins, its width, and whether it stands on the right.
struct Column {
    left: f64,
    width: f64,
    right: bool,
}

fn plain(title: &str) -> &str {
    title.trim_start_matches('>')
}

/// Columns as wide as what is in them, and narrower in proportion where they would not fit.
fn columns(table: &Table, room: f64) -> Vec<Column> {
    const BETWEEN: f64 = 4.0;
    let widest = |k: usize| {
        let cells = table.rows.iter().filter_map(|row| row.get(k)).map(|cell| width_of(cell, TEXT));
        cells.fold(width_of(plain(&table.columns[k]), TEXT) * 1.08, f64::max)
    };
    let widths: Vec<f64> = (0..table.columns.len()).map(widest).collect();
    let between = BETWEEN * widths.len().saturating_sub(1) as f64;
    let scale = ((room - between) / widths.iter().sum::<f64>().max(1.0)).min(1.0);
    let mut left = BORDER;
    let mut column = |(width, title): (f64, &String)| {
        let own = Column { left, width: width * scale, right: title.starts_with('>') };
        left += own.width + BETWEEN;
        own
    };
    widths.into_iter().zip(&table.columns).map(&mut column).collect()
}

fn row(page: &mut Page, font: Name<'_>, y: f64, columns: &[Column], cells: &[&str]) {
    for (column, cell) in columns.iter().zip(cells) {
        let (x, anchor) =
            if column.right { (column.left + column.width, Anchor::Right) } else { (column.left, Anchor::Left) };
        // What is too long is written smaller.
        let height = TEXT * (column.width / width_of(cell, TEXT).max(1e-9)).min(1.0);
        page.content.set_fill_gray(0.0);
        write_text(&mut page.content, font, Point::new(x, y), height, 0.0, anchor, cell);
    }
}

/// The file. It has no date and no identifier: equal boards give equal bytes.
fn assemble(pages: &[Page]) -> Vec<u8> {
    let id = |k: usize| Ref::new(i32::try_from(k).unwrap_or(i32::MAX));
    let (catalog, tree, fonts) = (id(1), id(2), [id(3), id(4)]);
    let ids: Vec<[Ref; 2]> = (0..pages.len()).map(|k| [id(5 + 2 * k), id(6 + 2 * k)]).collect();
    let mut pdf = Pdf::new();
    pdf.catalog(catalog).pages(tree);
    pdf.pages(tree).kids(ids.iter().map(|[page, _]| *page)).count(i32::try_from(pages.len()).unwrap_or(i32::MAX));
    for (font, name) in fonts.into_iter().zip([&b"Helvetica"[..], b"Helvetica-Bold"]) {
        pdf.type1_font(font).base_font(Name(name)).encoding_predefined(Name(b"WinAnsiEncoding"));
    }
    for ([page, content], own) in ids.into_iter().zip(pages) {
        let mut written = pdf.page(page);
        let [width, height] = own.size.map(|x| (x * POINTS) as f32);
        written.media_box(Rect::new(0.0, 0.0, width, height)).parent(tree).contents(content);
        written.resources().fonts().pair(FONT, fonts[0]).pair(BOLD, fonts[1]);
        written.finish();
        pdf.stream(content, own.content.as_bytes());
    }
    pdf.finish()
}
