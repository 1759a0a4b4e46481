//! Reads JSON, as `wireloom bench --json` prints it; `xtask` has no dependencies.

/// A JSON value.
#[derive(Clone, Debug, PartialEq)]
pub enum Json {
    /// `null`, `true` and `false`.
    Word,
    Number(f64),
    Text(String),
    List(Vec<Json>),
    Table(Vec<(String, Json)>),
}

/// Deepest nesting that is read.
const DEEPEST: usize = 64;

impl Json {
    /// Reads one value.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut reader = Reader { text, at: 0 };
        let value = reader.value(0)?;
        reader.space();
        if reader.at < text.len() { Err(reader.fault("the end")) } else { Ok(value) }
    }

    /// The value of a key of a table.
    pub fn get(&self, key: &str) -> Option<&Json> {
        match self {
            Json::Table(entries) => entries.iter().find(|(name, _)| name == key).map(|(_, value)| value),
            _ => None,
        }
    }

    pub fn number(&self) -> Option<f64> {
        if let Json::Number(value) = self { Some(*value) } else { None }
    }

    pub fn text(&self) -> Option<&str> {
        if let Json::Text(value) = self { Some(value) } else { None }
    }
}

struct Reader<'t> {
    text: &'t str,
    at: usize,
}

impl Reader<'_> {
    fn fault(&self, wanted: &str) -> String {
        let found: String = self.text[self.at..].chars().take(20).collect();
        format!("no JSON: {wanted} was expected at byte {}, not `{found}`", self.at)
    }

    fn space(&mut self) {
        let rest = &self.text[self.at..];
        self.at = self.text.len() - rest.trim_start().len();
    }

    /// Skips `word` if it comes next.
    fn comes(&mut self, word: &str) -> bool {
        self.space();
        let comes = self.text[self.at..].starts_with(word);
        self.at += if comes { word.len() } else { 0 };
        comes
    }

    fn value(&mut self, depth: usize) -> Result<Json, String> {
        if depth > DEEPEST {
            return Err(self.fault("less nesting"));
        }
        if ["null", "true", "false"].into_iter().any(|word| self.comes(word)) {
            return Ok(Json::Word);
        }
        if self.comes("[") {
            let mut entries = vec![];
            while !self.comes("]") {
                if !entries.is_empty() && !self.comes(",") {
                    return Err(self.fault("`,` or `]`"));
                }
                entries.push(self.value(depth + 1)?);
            }
            return Ok(Json::List(entries));
        }
        if self.comes("{") {
            let mut entries = vec![];
            while !self.comes("}") {
                if !entries.is_empty() && !self.comes(",") {
                    return Err(self.fault("`,` or `}`"));
                }
                self.space();
                let key = self.string()?;
                if !self.comes(":") {
                    return Err(self.fault("`:`"));
                }
                entries.push((key, self.value(depth + 1)?));
            }
            return Ok(Json::Table(entries));
        }
        if self.text[self.at..].starts_with('"') {
            return self.string().map(Json::Text);
        }
        let rest = &self.text[self.at..];
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && !"+-.".contains(c)).unwrap_or(rest.len());
        let number = rest[..end].parse().map_err(|_| self.fault("a value"))?;
        self.at += end;
        Ok(Json::Number(number))
    }

    fn string(&mut self) -> Result<String, String> {
        if !self.text[self.at..].starts_with('"') {
            return Err(self.fault("a string"));
        }
        let mut text = String::new();
        let mut all = self.text[self.at + 1..].char_indices();
        while let Some((k, c)) = all.next() {
            match c {
                '"' => {
                    self.at += 1 + k + 1;
                    return Ok(text);
                }
                '\\' => match all.next().map(|(_, c)| c) {
                    Some('n') => text.push('\n'),
                    Some('t') => text.push('\t'),
                    Some('r') => text.push('\r'),
                    Some('b') => text.push('\u{8}'),
                    Some('f') => text.push('\u{c}'),
                    Some('u') => {
                        let digits: String = all.by_ref().take(4).map(|(_, c)| c).collect();
                        let code = u32::from_str_radix(&digits, 16).map_err(|_| self.fault("four digits after \\u"))?;
                        // Halves of pairs: no name of a case has such characters.
                        text.push(char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER));
                    }
                    Some(c) => text.push(c),
                    None => break,
                },
                c => text.push(c),
            }
        }
        Err(self.fault("a string with an end"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read() {
        let text = r#" { "a": [1, -2.5e-3, true, null], "b\u00e4 \"\\": { "c": "x\ny" }, "d": [], "e": {} } "#;
        let read = Json::parse(text).expect("JSON");
        let list = vec![Json::Number(1.0), Json::Number(-2.5e-3), Json::Word, Json::Word];
        assert_eq!(read.get("a"), Some(&Json::List(list)));
        assert_eq!(read.get("bä \"\\").and_then(|b| b.get("c")).and_then(Json::text), Some("x\ny"));
        assert_eq!(read.get("d"), Some(&Json::List(vec![])));
        assert_eq!(read.get("e"), Some(&Json::Table(vec![])));
    }

    #[test]
    fn anything_else_is_refused() {
        for text in ["", "{", "[1 2]", "{\"a\" 1}", "{a: 1}", "\"a", "1 2", "wireloom", "\"\\u12", "[1,]"] {
            assert!(Json::parse(text).is_err(), "{text}");
        }
        assert!(Json::parse(&"[".repeat(100_000)).is_err());
    }
}
