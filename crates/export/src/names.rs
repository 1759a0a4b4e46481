//! Names of files.

/// File name for a name of the scenario: letters, digits, `-`, `_` and `.`; anything else becomes `_`. A name that is
/// in `taken` gets a number, also where only the case of letters differs.
pub fn file_name(name: &str, taken: &mut Vec<String>) -> String {
    let mut plain: String =
        name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
    if plain.trim_matches('.').is_empty() {
        plain = format!("_{plain}");
    }
    let mut unique = plain.clone();
    let mut k = 2;
    while taken.contains(&unique.to_lowercase()) {
        unique = format!("{plain}-{k}");
        k += 1;
    }
    taken.push(unique.to_lowercase());
    unique
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_are_safe_and_differ() {
        let mut taken = vec![];
        let mut name = |text| file_name(text, &mut taken);
        assert_eq!(name("plug B"), "plug_B");
        assert_eq!(name("plug/B"), "plug_B-2");
        assert_eq!(name("PLUG_B"), "PLUG_B-3");
        assert_eq!(name(".."), "_..");
        assert_eq!(name(""), "_");
        assert_eq!(name("Größe-2.5"), "Größe-2.5");
    }
}
