//! Checks of every request: host, origin and token.

use super::admission::Peer;
use super::state::ServerState;
use axum::extract::{Extension, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::IpAddr;
use std::sync::Arc;

/// Passes requests with a valid `Host`, a valid `Origin` and the token; refuses all others.
pub async fn guard(
    State(state): State<Arc<ServerState>>,
    Extension(peer): Extension<Arc<Peer>>,
    request: Request,
    next: Next,
) -> Response {
    let knows = is_own_host(request.headers(), &state.host)
        && is_own_origin(request.headers())
        && state.token.matches_query(request.uri().query());
    let away =
        |status: StatusCode, words: &'static str| (status, [(header::CONNECTION, "close")], words).into_response();
    let mut response = if !knows {
        let words = "This is a studio of wireloom. Its address has a token, a new one for each session: \
                     open the whole address that it printed.\n";
        away(StatusCode::FORBIDDEN, words)
    } else if !peer.authenticate() {
        away(StatusCode::SERVICE_UNAVAILABLE, "there are too many connections already: close some pages\n")
    } else {
        next.run(request).await
    };
    let always: [(HeaderName, &str); 4] = [
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        // Do not pass the token on to other sites.
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ];
    for (name, value) in always {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

/// Whether `Host` is a valid name of the server: an IP address, `localhost`, or the name it was bound to. Names of
/// other sites that resolve to this machine (DNS rebinding) are not. The port is not checked: a tunnel has its own.
fn is_own_host(headers: &HeaderMap, bound: &str) -> bool {
    let mut hosts = headers.get_all(header::HOST).iter();
    let (Some(host), None) = (hosts.next().and_then(|host| host.to_str().ok()), hosts.next()) else { return false };
    let name = match host.rsplit_once(':') {
        // Colons of an IPv6 address are within brackets.
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    };
    let bare = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
    name.eq_ignore_ascii_case("localhost") || name.eq_ignore_ascii_case(bound) || bare.parse::<IpAddr>().is_ok()
}

/// Whether the origin, if given, is a page of this server. Browsers always give it for WebSockets.
fn is_own_origin(headers: &HeaderMap) -> bool {
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default();
    headers.get_all(header::ORIGIN).iter().all(|origin| {
        origin.to_str().ok().and_then(|origin| origin.strip_prefix("http://")).is_some_and(|origin| origin == host)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(all: &[(HeaderName, &str)]) -> HeaderMap {
        all.iter().map(|(name, value)| (name.clone(), HeaderValue::try_from(*value).expect("a value"))).collect()
    }

    #[test]
    fn names_of_others_are_not_ours() {
        let named = |host: &str| is_own_host(&headers(&[(header::HOST, host)]), "studio.example");
        for own in ["127.0.0.1:8080", "localhost", "LOCALHOST:1", "[::1]:8080", "10.1.2.3:80", "studio.example:1"] {
            assert!(named(own), "{own}");
        }
        for other in
            ["", "evil.example:8080", "localhost.evil.example", "127.0.0.1.evil.example:80", "[::1", "localhost:80:80"]
        {
            assert!(!named(other), "{other}");
        }
        assert!(!is_own_host(&HeaderMap::new(), "127.0.0.1"));
    }

    #[test]
    fn pages_of_others_are_not_ours() {
        let from = |origin: &str| is_own_origin(&headers(&[(header::HOST, "localhost:80"), (header::ORIGIN, origin)]));
        assert!(from("http://localhost:80") && is_own_origin(&headers(&[(header::HOST, "localhost:80")])));
        for other in ["null", "", "https://localhost:80", "http://localhost:81", "http://evil.example", "file://"] {
            assert!(!from(other), "{other}");
        }
    }
}
