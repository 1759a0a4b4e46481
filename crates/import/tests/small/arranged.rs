//! The small harness on its board, and its assembly.

use super::*;

fn arranged(arrangement: Arrangement, order: Order) -> (toml::Table, Imported) {
    let imported = import(SMALL, &Options { arrangement, order, ..Options::default() }).unwrap();
    checked(&imported.scenario);
    (toml::from_str(&imported.scenario).unwrap(), imported)
}

fn tables<'t>(table: &'t toml::Table, key: &str) -> Vec<&'t toml::Table> {
    table.get(key).map_or(vec![], |list| list.as_array().unwrap().iter().map(|t| t.as_table().unwrap()).collect())
}

fn names(list: &[&toml::Table]) -> Vec<String> {
    list.iter().map(|table| table["name"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn a_board_is_flat_and_straight_and_true_to_length() {
    let (board, _) = arranged(Arrangement::Board, Order::Outward);
    let vector = |value: &toml::Value| -> Vec<f64> { value.as_array().unwrap().iter().map(float).collect() };
    let mut heights = Vec::new();
    for branch in tables(&board, "branches") {
        let path: Vec<Vec<f64>> = branch["path"].as_array().unwrap().iter().map(vector).collect();
        let [a, b] = &path[..] else { panic!("{path:?}") };
        let distance = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        assert!((distance - float(&branch["length"])).abs() < 1e-8, "{distance} {branch:?}");
        heights.extend([a[2], b[2]]);
    }
    let constraints = tables(&board, "constraints");
    heights.extend(constraints.iter().map(|c| vector(&c["position"])[2]));
    assert!(heights.iter().all(|z| (z - heights[0]).abs() < 1e-9), "{heights:?}");
    // The root is held fast, everything else by springy pegs.
    let fast: Vec<_> = constraints.iter().filter(|c| !c.contains_key("stiffness")).collect();
    assert_eq!(fast.len(), 1);
    assert!(!board.contains_key("steps"));
}

#[test]
fn an_assembly_has_one_step_for_each_connector_and_clip_in_the_order_asked_for() {
    let installed = names(&tables(&parsed(SMALL), "constraints"));
    let installs = |order: Order| {
        let (assembly, _) = arranged(Arrangement::Assembly, order);
        let steps = tables(&assembly, "steps");
        let operations = |step: &toml::Table| names(&[tables(step, "mate"), tables(step, "clip")].concat());
        let installs: Vec<String> = steps.iter().flat_map(|step| operations(step)).collect();
        assert_eq!(names(&steps)[..2], ["lift off the board", "carry to the vehicle"]);
        assert!(steps.iter().all(|step| tables(step, "mate").len() + tables(step, "clip").len() <= 1));
        assert_eq!(names(&steps)[steps.len() - 2..], ["take the twist out", "plug all in again"]);
        // Every hand is released.
        let hands = names(
            &steps[..steps.len() - 1]
                .iter()
                .flat_map(|step| [tables(step, "add"), tables(step, "grasp")].concat())
                .collect::<Vec<_>>(),
        );
        let released: Vec<&str> = steps
            .iter()
            .filter_map(|step| step.get("release"))
            .flat_map(|list| list.as_array().unwrap())
            .map(|name| name.as_str().unwrap())
            .collect();
        assert!(hands.iter().all(|hand| released.contains(&hand.as_str())), "{hands:?} {released:?}");
        let root = names(&tables(&assembly, "constraints"))[0].clone();
        let mut all = [vec![root], installs.clone()].concat();
        all.sort();
        let mut expected = installed.clone();
        expected.sort();
        assert_eq!(all, expected);
        installs
    };
    let outward = installs(Order::Outward);
    let random: Vec<Vec<String>> = (0..6).map(|seed| installs(Order::Random(seed))).collect();
    assert_eq!(random[1], installs(Order::Random(1)));
    assert!(random.iter().any(|order| *order != outward), "{outward:?}");
}

#[test]
fn a_piece_without_plugs_hangs_on_its_first_vertex_until_clips_hold_it() {
    let plug = |id: &str| format!("<Referenced_components>{id}</Referenced_components>");
    let bare = SMALL.replace(&plug("plugA"), "").replace(&plug("plugB"), "");
    let options = Options { arrangement: Arrangement::Assembly, ..Options::default() };
    let scenario = import(&bare, &options).unwrap().scenario;
    checked(&scenario);
    let assembly: toml::Table = toml::from_str(&scenario).unwrap();
    let steps = assembly["steps"].as_array().unwrap();
    let moved = steps[1]["move"].as_array().unwrap();
    assert!(moved.iter().any(|moved| moved["constraint"].as_str() == Some("board A")), "{moved:?}");
    let last = &steps[steps.len() - 1];
    assert_eq!(last["name"].as_str(), Some("let go"));
    assert!(last["release"].as_array().unwrap().iter().any(|name| name.as_str() == Some("board A")), "{last:?}");
}

/// Two segments leave the vertex that the board holds, so it is a joint, which has no frame that a connector could
/// hold: `check` refused what was imported (found by fuzzing).
#[test]
fn a_root_that_is_a_joint_is_held_at_its_point() {
    let looped = with("<Start_node>n3</Start_node>", "<Start_node>n1</Start_node>");
    for arrangement in [Arrangement::Board, Arrangement::Assembly] {
        let scenario = import(&looped, &Options { arrangement, ..Options::default() }).unwrap().scenario;
        checked(&scenario);
        let table: toml::Table = toml::from_str(&scenario).unwrap();
        let root = &table["constraints"][0];
        assert!(root["name"].as_str().is_some_and(|name| name.starts_with("board")), "{root:?}");
        assert_eq!((root["kind"].as_str(), root["at"].get("joint").is_some()), (Some("handle"), true), "{root:?}");
    }
}
