//! The JSON Schema agrees with the reader.

mod common;

use wireloom_scenario::{parse, schema};

#[test]
fn the_kinds_of_the_registry_and_their_parameters_are_in_it() {
    let schema = schema(&common::registry());
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    let constraint = &schema["properties"]["constraints"]["items"];
    let kinds: Vec<&str> = constraint["properties"]["kind"]["anyOf"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|k| k["const"].as_str())
        .collect();
    assert_eq!(kinds[..4], ["collar", "connector", "handle", "cushioned-clamp"]);
    let collar = &constraint["allOf"][0];
    assert_eq!(collar["if"]["properties"]["kind"]["const"], "collar");
    assert_eq!(collar["then"]["properties"]["twist"]["enum"], serde_json::json!(["free", "held"]));
    assert_eq!(collar["then"]["properties"]["twist"]["default"], "free");
    let handle = &constraint["allOf"][2]["then"]["properties"]["stiffness"];
    assert_eq!(handle["description"], "a spring between hand and cable (N/m)");
    assert_eq!(schema["properties"]["steps"]["items"]["properties"]["add"]["items"], *constraint);
}

#[test]
fn values_have_descriptions_units_and_limits() {
    let schema = schema(&common::registry());
    let length = &schema["properties"]["branches"]["items"]["properties"]["length"];
    assert_eq!(length["description"], "unstressed length (m)");
    assert_eq!((&length["anyOf"][0]["minimum"], &length["anyOf"][0]["maximum"]), (&1e-10.into(), &1e5.into()));
    assert_eq!(length["anyOf"][1]["type"], "string");
    let obstacle = &schema["properties"]["obstacles"]["items"];
    assert_eq!(obstacle["properties"]["friction"]["anyOf"][0]["minimum"], 0.0);
    assert_eq!(schema["additionalProperties"], false);
}

#[test]
fn a_section_is_measured_or_has_wires() {
    let schema = schema(&common::registry());
    let section = &schema["properties"]["sections"]["additionalProperties"];
    assert_eq!(section["required"], serde_json::json!([]));
    let unless = |others: &[&str], keys: &[&str]| {
        let others = others.iter().map(|other| serde_json::json!({ "required": [other] }));
        serde_json::json!({ "anyOf": others.chain([serde_json::json!({ "required": keys })]).collect::<Vec<_>>() })
    };
    let cases = [
        unless(&["wires"], &["diameter", "linear_density", "torsion_stiffness"]),
        unless(&["wires", "axial_curve"], &["axial_stiffness"]),
        unless(&["wires", "bending_curve"], &["bending_stiffness"]),
    ];
    assert_eq!(section["allOf"], serde_json::json!(cases));
    assert_eq!(section["dependentRequired"]["covering"], serde_json::json!(["wires"]));
    let covering = &section["properties"]["covering"]["anyOf"];
    assert_eq!(covering[0]["type"], "string");
    assert_eq!(covering[1]["required"], serde_json::json!(["type"]));
    assert_eq!(covering[2]["items"]["anyOf"][1], covering[1]);
    let wire = &schema["properties"]["wires"]["additionalProperties"];
    assert_eq!(wire["anyOf"][0]["required"], serde_json::json!(["like"]));
    assert_eq!(wire["anyOf"][1]["required"], serde_json::json!(["strands", "strand", "layers"]));
}

/// Every key of the schema is known to the reader: one that holds nonsense is refused for its value, not its name.
#[test]
fn every_key_of_the_schema_is_read() {
    let registry = common::registry();
    let schema = schema(&registry);
    for key in schema["properties"].as_object().unwrap().keys() {
        let text = format!("{key} = 1979-05-27");
        let faults = parse(&text, &registry).unwrap_err();
        let at_value = faults.iter().find(|fault| fault.span.start == key.len() + 3);
        let fault = at_value.unwrap_or_else(|| panic!("{key}: {faults:?}"));
        assert!(fault.message.contains(key.as_str()) && fault.message.contains("1979-05-27"), "{}", fault.message);
    }
}

/// Parameters of kinds included.
#[test]
fn every_number_of_the_schema_has_a_least_and_a_greatest_value() {
    let mut open = vec![schema(&common::registry())];
    let mut numbers = 0;
    while let Some(value) = open.pop() {
        if let Some(of) = value.as_object() {
            let with_unit = |of: &[serde_json::Value]| {
                let [number, text] = of else { return None };
                (number["type"] == "number" && text["type"] == "string").then(|| number.clone())
            };
            let number = if value["type"] == "integer" {
                Some(value.clone())
            } else {
                value["anyOf"].as_array().and_then(|of| with_unit(of))
            };
            if let Some(number) = number {
                let least = number.get("minimum").or(number.get("exclusiveMinimum"));
                assert!(least.is_some() && number.get("maximum").is_some(), "{value}");
                numbers += 1;
            }
            open.extend(of.values().cloned());
        } else if let Some(list) = value.as_array() {
            open.extend(list.iter().cloned());
        }
    }
    assert!(numbers > 100, "{numbers} numbers");
}
