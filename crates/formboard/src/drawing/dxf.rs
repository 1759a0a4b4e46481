//! DXF for CAD, in mm: centre lines as lines and arcs, dimensions as aligned ones with their own blocks, so that every
//! reader shows them.

use super::Drawing;
use super::scene::{Anchor, Layer, Shape, scene};
use crate::line::{Line, Point};
use dxf::entities::{Arc, Circle, Entity, EntityType, LwPolyline, RotatedDimension, Text};
use dxf::enums::{DimensionType, HorizontalTextJustification, Units};
use dxf::tables::Layer as DxfLayer;
use dxf::{Block, Color, LwPolylineVertex};
use std::io::Write;

/// A drawing that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("the DXF drawing cannot be written: {0}")]
pub struct DxfError(#[from] dxf::DxfError);

/// What a drawing without contents has in its header: with it, the same board gives the same bytes, on any day, in any
/// time zone.
const HEADER: &str = "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1015\n9\n$TDCREATE\n40\n2451545.0\n9\n$TDUCREATE\n40\n\
                      2451545.0\n9\n$TDUPDATE\n40\n2451545.0\n9\n$TDUUPDATE\n40\n2451545.0\n9\n$FINGERPRINTGUID\n2\n\
                      {00000000-0000-0000-0000-000000000001}\n9\n$VERSIONGUID\n2\n\
                      {00000000-0000-0000-0000-000000000001}\n0\nENDSEC\n0\nEOF\n";

/// Writes the drawing.
///
/// # Errors
/// Those of `out`.
pub fn dxf(drawing: &Drawing<'_>, out: &mut dyn Write) -> Result<(), DxfError> {
    let mut file = dxf::Drawing::load(&mut HEADER.as_bytes())?;
    file.header.default_drawing_units = Units::Millimeters;
    for layer in Layer::ALL {
        let color = Color::from_index(nearest(layer.colour()));
        file.add_layer(DxfLayer { name: layer.name().to_owned(), color, ..DxfLayer::default() });
    }
    let mut dimensions = 0;
    for (layer, shape) in scene(drawing) {
        if let Shape::Dimension { from, to, beside, text, .. } = &shape {
            dimensions += 1;
            let name = format!("*D{dimensions}");
            let entities = shape.dimension_parts().iter().flat_map(|part| entities(layer, part)).collect();
            file.add_block(Block { name: name.clone(), layer: layer.name().to_owned(), entities, ..Block::default() });
            let mut own = RotatedDimension::default();
            let along = (to - from).try_normalize(1e-9).unwrap_or_else(Point::x);
            let across = Point::new(-along.y, along.x) * *beside;
            own.dimension_base.dimension_type = DimensionType::Aligned;
            own.dimension_base.block_name = name;
            own.dimension_base.definition_point_1 = point(to + across);
            own.dimension_base.text_mid_point = point((from + to) * 0.5 + across);
            own.dimension_base.actual_measurement = (to - from).norm();
            own.dimension_base.text.clone_from(text);
            own.dimension_base.is_block_reference_referenced_by_this_block_only = true;
            own.definition_point_2 = point(*from);
            own.definition_point_3 = point(*to);
            file.add_entity(on(layer, EntityType::RotatedDimension(own)));
        }
        for entity in entities(layer, &shape) {
            file.add_entity(entity);
        }
    }
    file.save(out)?;
    Ok(())
}

/// The colour of the first seven of AutoCAD's that is nearest.
fn nearest([r, g, b]: [u8; 3]) -> u8 {
    const COLOURS: [[i32; 3]; 9] = [
        [255, 0, 0],
        [255, 255, 0],
        [0, 255, 0],
        [0, 255, 255],
        [0, 0, 255],
        [255, 0, 255],
        [0, 0, 0],
        [128, 128, 128],
        [192, 192, 192],
    ];
    let off = |c: &[i32; 3]| {
        let [x, y, z] = [r, g, b].map(i32::from);
        (c[0] - x).pow(2) + (c[1] - y).pow(2) + (c[2] - z).pow(2)
    };
    (0..9_u8).min_by_key(|&k| off(&COLOURS[usize::from(k)])).map_or(7, |k| k + 1)
}

fn on(layer: Layer, specific: EntityType) -> Entity {
    let mut entity = Entity::new(specific);
    entity.common.layer = layer.name().to_owned();
    entity
}

fn point(p: Point) -> dxf::Point {
    dxf::Point::new(p.x, p.y, 0.0)
}

/// Entities of a shape that is no dimension.
fn entities(layer: Layer, shape: &Shape) -> Vec<Entity> {
    let line = |a: Point, b: Point| on(layer, EntityType::Line(dxf::entities::Line::new(point(a), point(b))));
    match shape {
        Shape::Cable { line: own, .. } if own.curvature == 0.0 => vec![line(own.start, own.end())],
        Shape::Cable { line: own, .. } => vec![on(layer, EntityType::Arc(arc(own)))],
        Shape::Segment(a, b) => vec![line(*a, *b)],
        Shape::Circle { centre, radius } => {
            vec![on(layer, EntityType::Circle(Circle::new(point(*centre), *radius)))]
        }
        Shape::Polygon(points) => {
            let vertices = points.iter().map(|p| LwPolylineVertex { x: p.x, y: p.y, ..LwPolylineVertex::default() });
            let closed = LwPolyline { flags: 1, vertices: vertices.collect(), ..LwPolyline::default() };
            vec![on(layer, EntityType::LwPolyline(closed))]
        }
        Shape::Text { at, height, turn, anchor, text } => {
            let own = Text {
                location: point(*at),
                second_alignment_point: point(*at),
                text_height: *height,
                value: text.clone(),
                rotation: turn.to_degrees(),
                horizontal_text_justification: match anchor {
                    Anchor::Left => HorizontalTextJustification::Left,
                    Anchor::Middle => HorizontalTextJustification::Center,
                    Anchor::Right => HorizontalTextJustification::Right,
                },
                ..Text::default()
            };
            vec![on(layer, EntityType::Text(own))]
        }
        Shape::Dimension { .. } => Vec::new(),
    }
}

/// Arcs of DXF run counter-clockwise.
fn arc(line: &Line) -> Arc {
    let radius = 1.0 / line.curvature.abs();
    let left = line.curvature.signum();
    let across = |direction: f64| Point::new(-direction.sin(), direction.cos()) * left;
    let (first, last) = (line.direction, line.direction_at(line.length));
    let centre = line.start + across(first) * radius;
    // From the centre to a point of the line it is against the way across it.
    let angle = |direction: f64| {
        let outward = -across(direction);
        outward.y.atan2(outward.x).to_degrees().rem_euclid(360.0)
    };
    let (start, end) = if left > 0.0 { (first, last) } else { (last, first) };
    Arc::new(point(centre), radius, angle(start), angle(end))
}
