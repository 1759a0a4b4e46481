//! `.glb`, read back by the crate for the format, which validates on the way.

use crate::samples::{among_obstacles, broken, cube, failing, run, v, y_harness};
use gltf::scene::Transform;
use nalgebra::{Matrix4, Quaternion, UnitQuaternion};
use std::collections::BTreeMap;
use std::sync::Arc;
use wireloom_core::identity::{Identified, Identities, Identity, Part};
use wireloom_core::obstacle::Surface;
use wireloom_core::{StepResult, Vector};
use wireloom_export::gltf::{write, write_surface};
use wireloom_export::json::Provenance;

/// What a scene shows: by name, corners in its axes (turned back, so that z points up) and triangles.
type Shown = BTreeMap<String, (Vec<Vector>, Vec<[u32; 3]>)>;

fn scenes(bytes: &[u8]) -> Vec<(String, Shown)> {
    let file = gltf::Gltf::from_slice(bytes).expect("a valid file");
    let blob = file.blob.as_deref();
    let shown = |scene: gltf::Scene<'_>| {
        let roots: Vec<_> = scene.nodes().collect();
        assert_eq!(roots.len(), 1);
        let mut shown = Shown::new();
        for node in roots[0].children() {
            let upright = placed(&roots[0].transform());
            // y points up: z of the scenario is y of the file.
            assert!((upright.transform_vector(&Vector::z()) - Vector::y()).norm() < 1e-6);
            let own = placed(&node.transform());
            let (mut corners, mut triangles) = (vec![], vec![]);
            for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
                let reader = primitive.reader(|_| blob);
                let positions: Vec<[f32; 3]> = reader.read_positions().expect("positions").collect();
                let bounds = primitive.bounding_box();
                for (d, all) in [bounds.min, bounds.max].into_iter().zip([f32::min as fn(f32, f32) -> f32, f32::max]) {
                    let found = positions.iter().copied().reduce(|a, b| [0, 1, 2].map(|k| all(a[k], b[k])));
                    assert_eq!(found, Some(d));
                }
                for normal in reader.read_normals().into_iter().flatten() {
                    assert!((normal.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-5);
                }
                let place = |p: &[f32; 3]| own.transform_point(&p.map(f64::from).into()).coords;
                corners.extend(positions.iter().map(place));
                let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
                triangles.extend(indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]));
            }
            shown.insert(node.name().expect("a name").to_owned(), (corners, triangles));
        }
        (scene.name().expect("a name").to_owned(), shown)
    };
    file.scenes().map(shown).collect()
}

fn placed(transform: &Transform) -> Matrix4<f64> {
    let (translation, [x, y, z, w], scale) = transform.clone().decomposed();
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z).cast::<f64>());
    Matrix4::new_translation(&Vector::from(translation.map(f64::from)))
        * turn.to_homogeneous()
        * Matrix4::new_nonuniform_scaling(&Vector::from(scale.map(f64::from)))
}

/// By the divergence theorem; positive where triangles face outward.
fn volume((corners, triangles): &(Vec<Vector>, Vec<[u32; 3]>)) -> f64 {
    let at = |k: u32| corners[k as usize];
    triangles.iter().map(|t| at(t[0]).cross(&at(t[1])).dot(&at(t[2])) / 6.0).sum()
}

fn file(steps: &[&StepResult], obstacles: &[wireloom_core::obstacle::Obstacle]) -> Vec<u8> {
    let run = run("y", steps.iter().map(|step| (*step).clone()).collect());
    let mut bytes = vec![];
    write(&run, obstacles, &mut bytes).expect("written");
    bytes
}

/// The JSON part of a file.
fn document(bytes: &[u8]) -> serde_json::Value {
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).expect("JSON")
}

#[test]
fn nodes_have_the_part_numbers_of_their_parts() {
    let mut run = failing();
    let name = run.steps[0].branches[0].name.clone();
    let identity = Identity { part: Some("8K0 971 824".into()), ..Identity::default() };
    let parts = vec![Part { of: Identified::Branch, name: name.clone(), identity }];
    run.identities = Arc::new(Identities { parts, ..Identities::default() });
    let mut bytes = vec![];
    write(&run, &[], &mut bytes).expect("written");
    let file = document(&bytes);
    for node in file["nodes"].as_array().expect("a list") {
        let part = if node["name"] == *name { serde_json::json!("8K0 971 824") } else { serde_json::Value::Null };
        assert_eq!(node["extras"]["part"], part, "{node}");
    }
    assert_eq!(scenes(&bytes).len(), 1, "it stays valid");
}

#[test]
fn the_file_has_the_verdict_and_the_requirements_of_the_result() {
    let run = failing();
    let (mut bytes, mut result) = (vec![], vec![]);
    write(&run, &[], &mut bytes).expect("written");
    let file = document(&bytes);
    wireloom_export::json::write(&run, &Provenance::default(), &mut result).expect("written");
    let result: serde_json::Value = serde_json::from_slice(&result).expect("JSON");
    for key in ["status", "verdict", "requirements"] {
        assert_eq!(file["extras"][key], result[key], "{key}");
    }
    assert_eq!(file["extras"]["verdict"], "fail");
    assert!(scenes(&bytes).len() == 1, "it stays valid");
}

#[test]
fn a_harness_and_what_is_about_it_stand_where_they_are() {
    let end = among_obstacles().steps.remove(0);
    let mut moved = end.clone();
    moved.name = "moved".into();
    moved.obstacles[0].pose.position.x += 0.5;
    let scenes = scenes(&file(&[&end, &moved], &[cube(2)]));
    assert_eq!(scenes.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["equilibrium", "moved"]);
    for (step, (_, shown)) in [&end, &moved].into_iter().zip(&scenes) {
        let branches = step.branches.iter().map(|branch| branch.name.as_str());
        let mut names: Vec<&str> = branches.chain(step.constraints.iter().map(|c| c.name.as_str())).collect();
        names.push("a <cube>");
        names.sort_unstable();
        assert_eq!(shown.keys().map(String::as_str).collect::<Vec<_>>(), names);
        for branch in &step.branches {
            let tube = &shown[&branch.name];
            // Rings about the nodes, then the two ends.
            let sides = tube.0.len() / (branch.position.len() + 2);
            for (ring, x) in tube.0.chunks(sides).zip(&branch.position) {
                for corner in ring {
                    let off = (corner - x).norm();
                    assert!((off - 0.5 * branch.diameter).abs() < 1e-6, "{}: {off} m", branch.name);
                }
            }
            let length = branch.s[branch.s.len() - 1];
            let own = std::f64::consts::PI * 0.25 * branch.diameter.powi(2) * length;
            assert!((volume(tube) / own - 1.0).abs() < 0.04, "{}: {} m³, {own} m³", branch.name, volume(tube));
        }
        for constraint in &step.constraints {
            let corners = &shown[&constraint.name].0;
            let middle = corners.iter().sum::<Vector>() / corners.len() as f64;
            assert!((middle - constraint.position).norm() < 1e-6 && volume(&shown[&constraint.name]) > 0.0);
        }
        let body = &shown["a <cube>"];
        let middle = body.0.iter().sum::<Vector>() / body.0.len() as f64;
        assert!((middle - step.obstacles[0].pose.position).norm() < 1e-6 && (volume(body) - 0.008).abs() < 1e-6);
    }
}

#[test]
fn what_a_failed_run_left_is_a_valid_file() {
    let shown = scenes(&file(&[&broken()], &[]));
    // The trunk has a node that is no place, and so on.
    assert!(!shown[0].1.contains_key("trunk") && shown[0].1.contains_key("spare"));
    let mut torn = y_harness();
    torn.branches[1].frame.pop();
    assert!(write(&run("y", vec![torn]), &[], &mut vec![]).is_err());
}

#[test]
fn a_surface_comes_back_as_it_was() {
    let corners = vec![v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 2.0, 0.0), v(0.0, 0.0, 0.5)];
    let surface = Surface { corners: corners.clone(), triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] };
    let mut bytes = vec![];
    write_surface("swept", &surface, &mut bytes).expect("written");
    let scenes = scenes(&bytes);
    assert_eq!(scenes[0].1["swept"], (corners, surface.triangles));
}
