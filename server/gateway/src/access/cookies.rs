//! The secret of a session in a cookie, and that of a token in `Authorization`.

use api::access::Secret;
use axum::http::{HeaderMap, HeaderValue, header};
use vocab::Span;

/// Name of the cookie over TLS. The prefix makes browsers refuse it from other hosts, other paths and plain http.
const SECURE_NAME: &str = "__Host-autoinspect-session";
/// Name of the cookie over plain http.
const PLAIN_NAME: &str = "autoinspect-session";

const fn name(is_tls: bool) -> &'static str {
    if is_tls { SECURE_NAME } else { PLAIN_NAME }
}

/// The secret that a request presents. A request with a token is that of the token, whatever cookie it has. Of two cookies of one name somebody else has set one, so
/// none counts.
pub(super) fn presented(headers: &HeaderMap, is_tls: bool) -> Option<String> {
    let mut tokens = headers.get_all(header::AUTHORIZATION).iter();
    if let Some(token) = tokens.next() {
        let (scheme, secret) = token.to_str().ok()?.split_once(' ')?;
        let is_single = tokens.next().is_none();
        return (is_single && scheme.eq_ignore_ascii_case("bearer")).then(|| secret.trim().to_owned());
    }
    let texts = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
    let cookies = texts.flat_map(|text| text.split(';')).filter_map(|pair| pair.trim().split_once('='));
    let mut found = cookies.filter(|(other, _)| *other == name(is_tls)).map(|(_, value)| value.to_owned());
    let secret = found.next()?;
    found.next().is_none().then_some(secret)
}

/// Lets the browser keep the secret of a session. Scripts cannot read it, and pages of other sites do not send it.
pub(super) fn set_session(secret: &Secret, lifetime: Span, is_tls: bool) -> HeaderValue {
    let secure = if is_tls { "; Secure" } else { "" };
    let text = format!(
        "{}={}; Path=/; HttpOnly; SameSite=Strict; Max-Age={}{secure}",
        name(is_tls),
        secret.reveal(),
        lifetime.secs_f64().max(0.0) as u64,
    );
    // The secret has hexadecimal digits only.
    HeaderValue::try_from(text).unwrap_or_else(|_| HeaderValue::from_static(""))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn presented_by(lines: &[(header::HeaderName, &'static str)], is_tls: bool) -> Option<String> {
        let mut headers = HeaderMap::new();
        for (name, value) in lines {
            headers.append(name, HeaderValue::from_static(value));
        }
        presented(&headers, is_tls)
    }

    #[test]
    fn a_secret_comes_in_one_cookie_or_as_a_token() {
        let cookie = |value| (header::COOKIE, value);
        let token = |value| (header::AUTHORIZATION, value);
        assert_eq!(presented_by(&[cookie("a=b; autoinspect-session=s")], false), Some("s".into()));
        assert_eq!(presented_by(&[cookie("a=b; autoinspect-session=s")], true), None);
        assert_eq!(presented_by(&[cookie("__Host-autoinspect-session=s")], true), Some("s".into()));
        let two = [cookie("autoinspect-session=s"), cookie("autoinspect-session=t")];
        assert_eq!(presented_by(&two, false), None, "one of them was planted");
        assert_eq!(
            presented_by(&[token("Bearer t"), cookie("autoinspect-session=s")], false),
            Some("t".into())
        );
        assert_eq!(presented_by(&[token("Basic t"), cookie("autoinspect-session=s")], false), None);
        assert_eq!(presented_by(&[token("bearer  t ")], false), Some("t".into()));
        assert_eq!(presented_by(&[], false), None);
    }

    #[test]
    fn scripts_and_other_sites_do_not_get_the_cookie() {
        let of = |is_tls| set_session(&Secret::new("ab"), Span::from_millis(5_000), is_tls);
        assert_eq!(of(false), "autoinspect-session=ab; Path=/; HttpOnly; SameSite=Strict; Max-Age=5");
        assert_eq!(
            of(true),
            "__Host-autoinspect-session=ab; Path=/; HttpOnly; SameSite=Strict; Max-Age=5; Secure"
        );
    }
}
