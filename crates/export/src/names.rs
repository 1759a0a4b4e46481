//! Names of files.

/// Longest name, bytes: file systems allow 255, with the number and the extension.
const LONGEST: usize = 200;

/// File name for a name of the scenario: letters, digits, `-`, `_` and `.`; anything else becomes `_`. A long name is
/// shortened. A name that is in `taken` gets a number, also where only the case of letters differs.
pub fn file_name(name: &str, taken: &mut Vec<String>) -> String {
    let mut plain: String =
        name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
    plain.truncate(plain.floor_char_boundary(LONGEST));
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

    #[test]
    fn a_name_longer_than_a_file_system_allows_is_shortened() {
        let mut taken = vec![];
        let mut name = |text: &str| file_name(text, &mut taken);
        assert_eq!(name(&"a".repeat(300)), "a".repeat(200));
        assert_eq!(name(&"a".repeat(250)), "a".repeat(200) + "-2");
        // Whole characters, of two bytes each here.
        assert_eq!(name(&("b".to_owned() + &"ö".repeat(150))), "b".to_owned() + &"ö".repeat(99));
    }
}
