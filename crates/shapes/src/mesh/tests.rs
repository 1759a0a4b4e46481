use super::*;
use wireloom_core::obstacle::ShapeFile;
use wireloom_core::registry::ShapeKind;

/// A polygon in x and z, counter-clockwise, drawn out along y from −0.5 to 0.5; `floor` are the triangles of the
/// polygon, `rows` parts along y.
fn extruded(polygon: &[(f64, f64)], floor: &[[u32; 3]], rows: usize) -> Surface {
    let n = polygon.len() as u32;
    let mut surface = Surface::default();
    for row in 0..=rows {
        let y = row as f64 / rows as f64 - 0.5;
        surface.corners.extend(polygon.iter().map(|&(x, z)| Vector::new(x, y, z)));
    }
    for row in 0..rows as u32 {
        for k in 0..n {
            let (a, b) = (row * n + k, row * n + (k + 1) % n);
            surface.triangles.extend([[a, b, b + n], [a, b + n, a + n]].map(|t| [t[0], t[2], t[1]]));
        }
    }
    let last = rows as u32 * n;
    surface.triangles.extend(floor);
    surface.triangles.extend(floor.iter().map(|t| [t[0], t[2], t[1]].map(|k| k + last)));
    surface
}

/// A block with a V along its top, at right angles: its sides rise from (0, 0) to (±0.2, 0.2).
fn grooved(rows: usize) -> Surface {
    let polygon = [(0.0, 0.0), (-0.2, 0.2), (-0.4, 0.2), (-0.4, -0.3), (0.4, -0.3), (0.4, 0.2), (0.2, 0.2)];
    let floor = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 6]].map(|[a, b, c]| [a, c, b]);
    let mut surface = extruded(&polygon, &floor, rows);
    surface.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    surface
}

/// A sheet in x and y, from −0.5 to 0.5 along both, divided `n` times, raised by `height`.
fn sheet(n: usize, height: impl Fn(f64, f64) -> f64) -> Surface {
    let at = |k: usize| k as f64 / n as f64 - 0.5;
    let mut surface = Surface::default();
    for i in 0..=n {
        surface.corners.extend((0..=n).map(|j| Vector::new(at(i), at(j), height(at(i), at(j)))));
    }
    let corner = |i: usize, j: usize| (i * (n + 1) + j) as u32;
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        surface.triangles.extend([[a, b, c], [a, c, d]]);
    }
    surface
}

/// A box of edges 1, 0.6 and 0.4 m, each face divided `n` times along both edges.
fn finely_divided_box(n: usize) -> Surface {
    let face = sheet(n, |_, _| 0.5);
    let mut surface = Surface::default();
    for axis in 0..3 {
        for side in [1.0, -1.0] {
            let first = surface.corners.len() as u32;
            let place = |c: &Vector| {
                let mut placed = Vector::zeros();
                (placed[axis], placed[(axis + 1) % 3], placed[(axis + 2) % 3]) = (side * c.z, c.x, c.y * side);
                placed.component_mul(&Vector::new(1.0, 0.6, 0.4))
            };
            surface.corners.extend(face.corners.iter().map(place));
            surface.triangles.extend(face.triangles.iter().map(|t| t.map(|k| k + first)));
        }
    }
    surface
}

fn mesh(surface: &Surface) -> Mesh {
    Mesh::new(surface, false).expect("a closed surface")
}

wireloom_testkit::shape_conformance!(a_grooved_block, || Box::new(mesh(&grooved(3))));
wireloom_testkit::shape_conformance!(a_divided_box, || Box::new(mesh(&finely_divided_box(8))));
wireloom_testkit::shape_conformance!(a_sheet, || {
    Box::new(Mesh::new(&sheet(6, |x, y| 0.5 * (x * x - y * y)), true).expect("a sheet"))
});

fn touches(shape: &dyn Shape, x: [f64; 3], reach: f64) -> Vec<Touch> {
    let mut touches = Vec::new();
    shape.touches(&Vector::from(x), reach, &mut |touch| touches.push(touch));
    touches
}

/// A cable of radius 0.05 rests at height 0.05 √2 over the bottom; along the groove it keeps its two touches, each with
/// its part.
#[test]
fn a_cable_in_a_groove_touches_both_sides_all_along() {
    let block = mesh(&grooved(7));
    let height = 0.05 * 2_f64.sqrt();
    let mut parts = None;
    for y in [-0.45, -0.2, 0.013, 0.31, 0.45] {
        let found = touches(&block, [0.0, y, height], 0.06);
        assert_eq!(found.len(), 2, "{found:?}");
        for touch in &found {
            assert!((touch.distance - 0.05).abs() < 1e-15, "{touch:?}");
            assert!((touch.normal.x.abs() - touch.normal.z).abs() < 1e-15, "{touch:?}");
        }
        let own = [found[0].part, found[1].part];
        assert_eq!(*parts.get_or_insert(own), own, "at y = {y}");
    }
    // Out of the middle each side is still told by itself, however much nearer the other one is.
    assert_eq!(touches(&block, [0.04, 0.0, 0.09], 0.1).len(), 2);
}

/// Beside a corner that sticks out there is one nearest place, seen from wherever.
#[test]
fn faces_that_meet_in_an_edge_touch_once() {
    let block = mesh(&grooved(2));
    for x in
        [[0.45, 0.1, 0.25], [0.45, 0.1, 0.2], [0.3, 0.1, 0.25], [0.4, 0.1, 0.22], [0.45, 0.55, 0.25], [0.38, 0.0, 0.21]]
    {
        assert_eq!(touches(&block, x, 0.1).len(), 1, "at {x:?}: {:?}", touches(&block, x, 0.1));
    }
}

/// Faces hidden by another face are not touched.
#[test]
fn the_far_side_of_a_thin_wall_is_not_touched() {
    // An angle of two legs, 0.01 thick.
    let polygon = [(0.0, 0.0), (0.3, 0.0), (0.3, 0.01), (0.01, 0.01), (0.01, 0.3), (0.0, 0.3)];
    let floor = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
    let angle = mesh(&extruded(&polygon, &floor, 4));
    assert_eq!(touches(&angle, [0.1, 0.0, -0.02], 0.05).len(), 1);
    assert_eq!(touches(&angle, [0.2, 0.0, 0.03], 0.05).len(), 1);
    assert_eq!(touches(&angle, [0.04, 0.0, 0.04], 0.05).len(), 2);
    // Within the wall the nearest way out counts alone.
    let inside = touches(&angle, [0.2, 0.0, 0.008], 0.05);
    assert!(inside.len() == 1 && (inside[0].distance + 0.002).abs() < 1e-15, "{inside:?}");
}

/// However a flat face is divided, it is flat: the same distances and normals to round-off, no bending.
#[test]
fn a_finely_divided_box_is_a_box() {
    let (coarse, fine) = (mesh(&finely_divided_box(1)), mesh(&finely_divided_box(40)));
    assert_eq!((coarse.parts(), fine.parts()), (1, 1));
    let mut rng = fastrand::Rng::with_seed(9);
    for _ in 0..2000 {
        let x = [1.4, 1.0, 0.8].map(|size| size * (rng.f64() - 0.5));
        let (a, b) = (touches(&coarse, x, 0.2), touches(&fine, x, 0.2));
        assert_eq!(a.len(), b.len(), "at {x:?}");
        for (a, b) in a.iter().zip(&b).filter(|(a, _)| a.distance > 0.0) {
            assert!((a.distance - b.distance).abs() < 1e-13, "{a:?} and {b:?} at {x:?}");
            assert!((a.normal - b.normal).norm() < 1e-9, "{a:?} and {b:?} at {x:?}");
            assert!((a.curvature - b.curvature).norm() < 1e-6 * (1.0 + a.curvature.norm()), "{a:?} and {b:?} at {x:?}");
        }
    }
}

/// Also with a groove, where it is cut into parts, and with coordinates of single precision.
#[test]
fn parts_do_not_depend_on_how_faces_are_divided() {
    let single = |mut surface: Surface| {
        surface.corners.iter_mut().for_each(|c| *c = c.map(|c| f64::from((c + 0.1) as f32)));
        surface
    };
    let (coarse, fine) = (mesh(&grooved(1)), mesh(&single(grooved(150))));
    assert_eq!(coarse.parts(), fine.parts());
}

#[test]
fn faults_of_surfaces_say_how_many_and_where() {
    let refused = |surface: &Surface| Mesh::new(surface, false).err().expect("it is refused");
    let mut holed = finely_divided_box(1);
    holed.triangles.remove(0);
    assert!(matches!(refused(&holed), MeshFault::Open { edges: 3, .. }), "{}", refused(&holed));
    assert!(Mesh::new(&holed, true).is_ok());
    let mut crowded = finely_divided_box(1);
    let [a, b, _] = crowded.triangles[0];
    crowded.corners.push(Vector::new(0.0, 0.0, 3.0));
    crowded.triangles.push([a, b, crowded.corners.len() as u32 - 1]);
    assert!(
        matches!(refused(&crowded), MeshFault::NonManifold { edges: 1, triangles: 3, .. }),
        "{}",
        refused(&crowded)
    );
    assert_eq!(refused(&Surface::default()), MeshFault::Empty);
    let mut large = finely_divided_box(1);
    large.corners.iter_mut().for_each(|c| *c *= 2000.0);
    assert_eq!(refused(&large), MeshFault::Gigantic { size: 2000.0 });
    let mut no_number = finely_divided_box(1);
    no_number.corners[5].y = f64::NAN;
    assert_eq!(refused(&no_number), MeshFault::NotFinite { corner: 5 });
    let mut damaged = finely_divided_box(1);
    damaged.triangles[3][1] = 99;
    assert!(matches!(refused(&damaged), MeshFault::NoSuchCorner { triangle: 3, corner: 99, .. }));
    let line = Surface { corners: vec![Vector::zeros(), Vector::x(), Vector::x()], triangles: vec![[0, 1, 2]] };
    assert_eq!(refused(&line), MeshFault::Degenerate { triangles: 1 });
}

/// Seven triangles around a strip that is turned over once.
#[test]
fn a_surface_of_one_side_is_refused() {
    let corner = |k: usize| {
        let angle = std::f64::consts::TAU * (k / 2) as f64 / 9.0;
        let across = if k.is_multiple_of(2) { 0.1 } else { -0.1 };
        let tilt = 0.5 * angle;
        let out = Vector::new(angle.cos(), angle.sin(), 0.0);
        out + (out * tilt.cos() + Vector::z() * tilt.sin()) * across
    };
    let corners: Vec<Vector> = (0..18).map(corner).collect();
    let mut triangles: Vec<[u32; 3]> = (0..16).map(|k| [k, k + 1, k + 2]).collect();
    triangles.extend([[16, 17, 1], [17, 1, 0]]);
    let fault = Mesh::new(&Surface { corners, triangles }, true).err().expect("it is refused");
    assert!(matches!(fault, MeshFault::OneSided { .. }), "{fault}");
}

#[test]
fn surfaces_that_face_the_wrong_way_are_turned_and_it_is_said() {
    let x = [0.0, 0.0, 0.3];
    let mut inside_out = finely_divided_box(2);
    inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let mut muddled = finely_divided_box(2);
    muddled.triangles.iter_mut().step_by(3).for_each(|t| t.swap(0, 1));
    let mut slivers = finely_divided_box(2);
    slivers.triangles.push([4, 4, 5]);
    for (surface, note) in [
        (inside_out, "its triangles faced inward and are turned"),
        (muddled, "of its triangles faced the other way than their neighbours and are turned"),
        (slivers, "1 of its 49 triangles have no area and are left out"),
    ] {
        let turned = mesh(&surface);
        assert!((turned.distance(&Vector::from(x), 1.0) - 0.1).abs() < 1e-15);
        assert!(turned.notes().iter().any(|own| own.ends_with(note)), "{:?}", turned.notes());
    }
}

/// As STL text, binary STL, OBJ, PLY and glTF.
fn files(surface: &Surface) -> Vec<ShapeFile> {
    let mut stl = String::from("solid a\n");
    let mut binary =
        [b"solid but binary".to_vec(), vec![0; 64], (surface.triangles.len() as u32).to_le_bytes().to_vec()].concat();
    let mut obj = String::from("# a body\no body\n");
    let mut ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        surface.corners.len(),
        surface.triangles.len()
    );
    for c in &surface.corners {
        obj += &format!("v {} {} {}\n", c.x, c.y, c.z);
        ply += &format!("{} {} {}\n", c.x, c.y, c.z);
    }
    for t in &surface.triangles {
        stl += "facet normal 0 0 0\nouter loop\n";
        binary.extend([0; 12]);
        for c in t.map(|k| surface.corners[k as usize]) {
            stl += &format!("vertex {} {} {}\n", c.x, c.y, c.z);
            binary.extend(c.iter().flat_map(|c| (*c as f32).to_le_bytes()));
        }
        stl += "endloop\nendfacet\n";
        binary.extend([0; 2]);
        obj += &format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
        ply += &format!("3 {} {} {}\n", t[0], t[1], t[2]);
    }
    stl += "endsolid a\n";
    let places: Vec<u8> = surface
        .corners
        .iter()
        .flat_map(|c| c.iter().flat_map(|c| (*c as f32).to_le_bytes()).collect::<Vec<u8>>())
        .collect();
    let indices: Vec<u8> = surface.triangles.iter().flatten().flat_map(|k| k.to_le_bytes()).collect();
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode([places.as_slice(), indices.as_slice()].concat());
    let gltf = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
            "nodes":[{{"children":[1]}},{{"mesh":0,"scale":[1,1,1]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]}},
                     {{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}}],
        "buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{data}"}}]}}"#,
        surface.corners.len(),
        3 * surface.triangles.len(),
        places.len(),
        places.len(),
        indices.len(),
        places.len() + indices.len(),
    );
    [
        ("a.stl", stl.into_bytes()),
        ("b.STL", binary),
        ("a.obj", obj.into_bytes()),
        ("a.ply", ply.into_bytes()),
        ("a.gltf", gltf.into_bytes()),
    ]
    .map(|(name, bytes)| ShapeFile { name: name.into(), bytes, scale: 0.5 })
    .into()
}

#[test]
fn every_format_gives_the_same_body() {
    let surface = finely_divided_box(2);
    for file in files(&surface) {
        let read = read(&file).unwrap_or_else(|fault| panic!("{}: {fault}", file.name));
        let body = Mesh::new(&read, false).unwrap_or_else(|fault| panic!("{}: {fault}", file.name));
        let distance = body.distance(&Vector::new(0.0, 0.0, 0.3), 1.0);
        assert!((distance - 0.2).abs() < 1e-8, "{}: {distance}", file.name);
    }
}

/// Files that are damaged at random give triangles or a fault, never a panic.
#[test]
fn damaged_files_do_no_harm() {
    let mut rng = fastrand::Rng::with_seed(11);
    let (mut faults, mut bodies) = (0, 0);
    for file in files(&finely_divided_box(1)) {
        for _ in 0..300 {
            let mut damaged = file.clone();
            for _ in 0..rng.usize(1..6) {
                let at = rng.usize(..damaged.bytes.len());
                match rng.u8(..4) {
                    0 => damaged.bytes.truncate(at.max(1)),
                    1 => damaged.bytes[at] = rng.u8(..),
                    2 => damaged.bytes[at] = *rng.choice(b"0123456789-.e \n{}[]").expect("a byte"),
                    _ => damaged.bytes.insert(at, rng.u8(..)),
                }
            }
            match read(&damaged) {
                Ok(surface) if Mesh::new(&surface, false).is_ok() => bodies += 1,
                _ => faults += 1,
            }
        }
    }
    assert!(faults > 100 && bodies > 10, "{faults} faults, {bodies} bodies");
}

#[test]
fn faults_of_files_name_them() {
    let kind: ShapeKind = kind(None);
    let refused = |name: &str, bytes: &[u8]| {
        let file = ShapeFile { name: name.into(), bytes: bytes.into(), scale: 1.0 };
        let spec = wireloom_core::obstacle::ShapeSpec { file: Some(file) };
        let fault = (kind.build)(&spec, &wireloom_core::Parameters::default()).err().expect("it is refused");
        (fault.message, fault.key)
    };
    assert_eq!(refused("panel.dwg", b"").0, "\"panel.dwg\" is of no known format");
    let (message, key) = refused("panel.ply", b"plx\n");
    assert!(message.starts_with("\"panel.ply\" cannot be read as PLY: "), "{message}");
    assert_eq!(key.as_deref(), Some("mesh"));
    assert!(refused("panel.stl", b"").0.starts_with("\"panel.stl\" cannot be read as STL: "));
    assert_eq!(refused("panel.obj", b"v 0 0 0\n").0, "it has no triangles");
}

/// Corners at one far place have no size to compare distances with.
#[test]
fn a_sheet_of_no_size_far_away_is_refused() {
    let corners = vec![Vector::repeat(1e300), Vector::repeat(1e300), Vector::new(1e300, 1e300, -1e300)];
    for corners in [corners.clone(), vec![corners[0], corners[0].map(f64::next_up), corners[0].map(f64::next_down)]] {
        let surface = Surface { corners, triangles: vec![[0, 1, 2]] };
        assert!(Mesh::new(&surface, true).is_err() && Mesh::new(&surface, false).is_err());
    }
}
