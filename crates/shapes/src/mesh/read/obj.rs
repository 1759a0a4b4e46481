//! Wavefront OBJ: the polygons of all its groups, assumed convex. Only surfaces are read. An own reader, because
//! the crate for this format overflows at large indices, of textures and normals too.

use super::polygon::fan;
use wireloom_core::Vector;
use wireloom_core::obstacle::Surface;

pub(super) fn read(bytes: &[u8]) -> Result<Surface, String> {
    let text = String::from_utf8_lossy(bytes);
    let mut surface = Surface::default();
    let mut polygon = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((k, line)) = lines.next() {
        // A line that ends with a backslash goes on.
        let mut whole = line.split('#').next().unwrap_or_default().trim_end().to_owned();
        while whole.ends_with('\\') {
            whole.pop();
            let Some((_, next)) = lines.next() else { break };
            whole += next.split('#').next().unwrap_or_default().trim_end();
        }
        let wrong = |what: &str| format!("line {}: {what}", k + 1);
        let mut words = whole.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut coordinate = || words.next().and_then(|word| word.parse::<f64>().ok());
                let corner = (|| Some(Vector::new(coordinate()?, coordinate()?, coordinate()?)))();
                surface.corners.push(corner.ok_or_else(|| wrong("a corner needs three numbers"))?);
            }
            Some("f") => {
                polygon.clear();
                for word in words {
                    // Corner, texture and normal; corners count from 1, or back from the last one.
                    let corner = word.split('/').next().and_then(|word| word.parse::<i64>().ok());
                    let last = surface.corners.len() as i64;
                    let place = corner.and_then(|k| if k < 0 { last.checked_add(k) } else { k.checked_sub(1) });
                    let place = place.and_then(|place| u32::try_from(place).ok());
                    polygon.push(place.ok_or_else(|| wrong(&format!("`{word}` names no corner")))?);
                }
                surface.triangles.extend(fan(&polygon));
            }
            _ => {}
        }
    }
    Ok(surface)
}
