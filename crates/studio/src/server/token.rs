//! Access token of a session: a new random number.

use std::fmt;

/// Size, bytes: 128 bits cannot be guessed.
const BYTES: usize = 16;

/// A secret random number, known to the users of a server.
#[derive(Clone, PartialEq, Eq)]
pub struct Token(String);

impl Token {
    /// A new random token.
    ///
    /// # Errors
    /// If the system has no random numbers; its message.
    pub fn random() -> Result<Self, String> {
        let mut bytes = [0; BYTES];
        getrandom::fill(&mut bytes).map_err(|error| error.to_string())?;
        Ok(Self(bytes.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    /// The digits for an address.
    pub fn digits(&self) -> &str {
        &self.0
    }

    /// Whether a query (`a=b&token=…`) contains the token. Compares in constant time.
    pub(super) fn matches_query(&self, query: Option<&str>) -> bool {
        let given = query.into_iter().flat_map(|query| query.split('&')).find_map(|pair| pair.strip_prefix("token="));
        given.is_some_and(|given| {
            given.len() == self.0.len() && given.bytes().zip(self.0.bytes()).fold(0, |all, (a, b)| all | (a ^ b)) == 0
        })
    }
}

/// Hides the digits, so that debug output does not give access.
impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token")
    }
}

#[cfg(test)]
mod tests {
    use super::Token;

    #[test]
    fn only_the_whole_token_is_the_token() {
        let token = Token::random().expect("random numbers");
        let digits = token.digits();
        assert!(
            token.matches_query(Some(&format!("token={digits}")))
                && token.matches_query(Some(&format!("a=b&token={digits}")))
        );
        let upper = digits.to_uppercase();
        for wrong in ["", &digits[1..], &format!("{digits}0"), &"0".repeat(32), &format!("{upper}g")] {
            assert!(!token.matches_query(Some(&format!("token={wrong}"))), "{wrong}");
        }
        assert!(
            !token.matches_query(None) && !token.matches_query(Some(digits)) && !token.matches_query(Some("token"))
        );
        assert_ne!(token, Token::random().expect("random numbers"));
        assert_eq!(format!("{token:?}"), "Token");
    }
}
