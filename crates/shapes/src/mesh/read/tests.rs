//! Files that are small and claim much: refused at once, with little memory.

use super::*;
use serde_json::json;
use std::time::{Duration, Instant};

/// Message with which a file is refused; it must come quickly.
fn refused(name: &str, bytes: Vec<u8>) -> String {
    let begun = Instant::now();
    let file = ShapeFile { name: name.into(), bytes, scale: 1.0 };
    let fault = read(&file).expect_err("a file that must be refused");
    assert!(begun.elapsed() < Duration::from_secs(5), "{:?}: {fault}", begun.elapsed());
    fault.to_string()
}

/// A triangle with `indices` that say it so many times, in the nodes `nodes`.
fn gltf(nodes: &serde_json::Value, times: usize) -> Vec<u8> {
    use base64::Engine;
    let mut data: Vec<u8> =
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    data.extend([0_u8, 1, 2].repeat(times));
    let data = base64::engine::general_purpose::STANDARD.encode(data);
    let uri = format!("data:application/octet-stream;base64,{data}");
    let document = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": nodes,
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5121, "count": 3 * times, "type": "SCALAR" },
        ],
        "bufferViews": [{ "buffer": 0 }, { "buffer": 0, "byteOffset": 36 }],
        "buffers": [{ "uri": uri }],
    });
    document.to_string().into_bytes()
}

#[test]
fn a_gltf_whose_nodes_form_a_graph_with_many_paths_is_refused() {
    // Each node has the next one as a child twice: 2⁹⁰ ways to the last.
    let mut nodes: Vec<_> = (1..90).map(|k| json!({ "children": [k, k] })).collect();
    nodes.push(json!({ "mesh": 0 }));
    let fault = refused("paths.gltf", gltf(&json!(nodes), 1));
    assert!(fault.contains("node 89 lies within two others, or within itself"), "{fault}");
    let fault = refused("ring.gltf", gltf(&json!([{ "children": [1] }, { "children": [0] }]), 1));
    assert!(fault.contains("node 0 lies within two others"), "{fault}");
}

#[test]
fn a_gltf_that_sets_a_large_mesh_in_very_many_places_is_refused() {
    let children: Vec<usize> = (1..=20_000).collect();
    let mut nodes = vec![json!({ "children": children })];
    nodes.extend((1..=20_000).map(|_| json!({ "mesh": 0 })));
    let fault = refused("bomb.gltf", gltf(&json!(nodes), 20_000));
    assert!(fault.contains("it has more than 2000000 triangles"), "{fault}");
}

#[test]
fn a_gltf_that_sets_a_mesh_in_some_places_is_read() {
    let nodes = json!([{ "children": [1, 2] }, { "mesh": 0 }, { "mesh": 0, "translation": [0, 0, 1] }]);
    let file = ShapeFile { name: "two.gltf".into(), bytes: gltf(&nodes, 1), scale: 1.0 };
    assert_eq!(read(&file).map(|surface| surface.triangles), Ok(vec![[0, 1, 2], [3, 4, 5]]));
}

/// A document with one change of its text.
fn changed(from: &str, to: &str) -> Vec<u8> {
    let text = String::from_utf8(gltf(&json!([{ "mesh": 0 }]), 1)).expect("a text");
    assert!(text.contains(from), "{text}");
    text.replacen(from, to, 1).into_bytes()
}

/// The format demands that a reader which does not know a required extension reads nothing.
#[test]
fn a_gltf_that_needs_an_unknown_extension_is_not_read_without_what_that_adds() {
    let required = |name: &str| changed("\"asset\":", &format!("\"extensionsRequired\":[\"{name}\"],\"asset\":"));
    for name in ["EXT_mesh_gpu_instancing", "KHR_draco_mesh_compression", "KHR_made_up"] {
        let fault = refused("extension.gltf", required(name));
        assert!(fault.contains(&format!("it needs the extension {name}")), "{fault}");
    }
    for name in ["KHR_materials_unlit", "KHR_texture_transform", "KHR_mesh_quantization"] {
        let file = ShapeFile { name: "plain.gltf".into(), bytes: required(name), scale: 1.0 };
        assert_eq!(read(&file).map(|surface| surface.triangles), Ok(vec![[0, 1, 2]]));
    }
}

#[test]
fn a_gltf_with_a_skin_a_morph_or_instances_is_not_read_as_if_it_stood_still() {
    let mesh = "\"primitives\":[{";
    let morph =
        |weights: &str| changed(mesh, &format!("\"weights\":[{weights}],\"primitives\":[{{\"targets\":[{{}}],"));
    let node = |more: &str| changed("\"mesh\":0", &format!("\"mesh\":0,{more}"));
    for (bytes, what) in [
        (morph("1"), "a morph target with a weight other than 0"),
        (node("\"skin\":0"), "a skin"),
        (node("\"extensions\":{\"EXT_mesh_gpu_instancing\":{}}"), "EXT_mesh_gpu_instancing"),
    ] {
        let fault = refused("moved.gltf", bytes);
        assert!(fault.contains(&format!("node 0 has {what}, which is not read")), "{fault}");
    }
    let file = ShapeFile { name: "still.gltf".into(), bytes: morph("0"), scale: 1.0 };
    assert!(read(&file).is_ok());
}

#[test]
fn a_ply_with_a_huge_count_of_empty_elements_is_refused() {
    for format in ["binary_little_endian", "ascii"] {
        let text = format!("ply\nformat {format} 1.0\nelement nothing 1000000000000\nend_header\n");
        let fault = refused("empty.ply", text.into_bytes());
        assert!(fault.contains("it has 1000000000000 of `nothing`, which have no properties"), "{fault}");
    }
}

#[test]
fn counts_beyond_the_end_of_a_file_are_refused() {
    let header = |element: &str| format!("ply\nformat binary_little_endian 1.0\n{element}\nend_header\n").into_bytes();
    refused("vertices.ply", header("element vertex 1000000000000\nproperty float x"));
    let mut list = header("element face 1\nproperty list uint int vertex_indices");
    list.extend(u32::MAX.to_le_bytes());
    refused("list.ply", list);
    let mut triangles = vec![0; 80];
    triangles.extend(u32::MAX.to_le_bytes());
    refused("triangles.stl", triangles);
}
