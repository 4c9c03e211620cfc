//! [`Source`]: Rust text, parted into code and comments.
//!
//! Enough of Rust's lexical grammar to tell the two apart: nested block comments, strings with
//! escapes, raw strings, and `'a'` against the lifetime `'a`. Rules that look for a call look at
//! the code, rules that look for words look at the comments, and neither sees a string.

/// A Rust file, parted. Both texts have the lines and columns of the original; what belongs to the
/// other one, or to a string or character literal, is blank.
pub struct Source {
    /// Everything that is compiled, without the contents of literals.
    pub code: String,
    /// Comments of all kinds, with their slashes.
    pub comments: String,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Code,
    Comment,
    Literal,
}

impl Source {
    /// Parts `text`. Text that is no valid Rust is parted somehow.
    pub fn new(text: &str) -> Self {
        let chars: Vec<char> = text.chars().collect();
        let mut source = Self { code: String::with_capacity(text.len()), comments: String::new() };
        let mut at = 0;
        while at < chars.len() {
            let (kind, len) = token(&chars, at);
            for &c in &chars[at..at + len] {
                source.push(kind, c);
            }
            at += len;
        }
        source
    }

    /// The code without the bodies of `#[cfg(test)]` modules.
    pub fn shipped_code(&self) -> String {
        let mut code = self.code.clone();
        while let Some(start) = code.find("#[cfg(test)]") {
            let end = end_of_item(&code, start);
            let blank: String =
                code[start..end].chars().map(|c| if c == '\n' { '\n' } else { ' ' }).collect();
            code.replace_range(start..end, &blank);
        }
        code
    }

    fn push(&mut self, kind: Kind, c: char) {
        let blank = if c == '\n' { '\n' } else { ' ' };
        let (code, comment) = match kind {
            Kind::Code => (c, blank),
            Kind::Comment => (blank, c),
            Kind::Literal => (blank, blank),
        };
        self.code.push(code);
        self.comments.push(comment);
    }
}

/// Kind and length of what begins at `at`.
fn token(chars: &[char], at: usize) -> (Kind, usize) {
    let rest = &chars[at..];
    match rest {
        ['/', '/', ..] => {
            let len = rest.iter().position(|&c| c == '\n').unwrap_or(rest.len());
            (Kind::Comment, len)
        }
        ['/', '*', ..] => (Kind::Comment, block_comment(rest)),
        ['"', ..] => (Kind::Literal, string(rest)),
        ['\'', '\\', ..] => (Kind::Literal, character(rest)),
        ['\'', _, '\'', ..] => (Kind::Literal, 3),
        ['r', '"' | '#', ..] if starts_raw_string(chars, at) => (Kind::Literal, raw_string(rest)),
        _ => (Kind::Code, 1),
    }
}

fn block_comment(rest: &[char]) -> usize {
    let (mut depth, mut at) = (0_usize, 0);
    while at < rest.len() {
        match rest[at..] {
            ['/', '*', ..] => {
                depth += 1;
                at += 2;
            }
            ['*', '/', ..] => {
                depth -= 1;
                at += 2;
                if depth == 0 {
                    return at;
                }
            }
            _ => at += 1,
        }
    }
    rest.len()
}

fn string(rest: &[char]) -> usize {
    let mut at = 1;
    while at < rest.len() {
        match rest[at] {
            '\\' => at += 2,
            '"' => return at + 1,
            _ => at += 1,
        }
    }
    rest.len()
}

/// An escaped character literal: quote, backslash, escaped character, ..., quote.
fn character(rest: &[char]) -> usize {
    rest.iter().skip(3).position(|&c| c == '\'').map_or(rest.len(), |end| end + 4)
}

fn starts_raw_string(chars: &[char], at: usize) -> bool {
    let before = at.checked_sub(1).map(|i| chars[i]);
    // The r of an identifier that ends in r; br and cr do begin raw strings.
    let inside = before.is_some_and(|c| (c.is_alphanumeric() || c == '_') && !"bc".contains(c));
    let quote = chars[at + 1..].iter().find(|&&c| c != '#');
    !inside && quote == Some(&'"')
}

fn raw_string(rest: &[char]) -> usize {
    let hashes = rest[1..].iter().take_while(|&&c| c == '#').count();
    let mut closing = vec!['"'];
    closing.extend(std::iter::repeat_n('#', hashes));
    let body = &rest[hashes + 2..];
    body.windows(closing.len())
        .position(|window| window == closing)
        .map_or(rest.len(), |end| hashes + 2 + end + closing.len())
}

/// One past the item that the attribute at `start` belongs to.
fn end_of_item(code: &str, start: usize) -> usize {
    let mut depth = 0_usize;
    for (at, c) in code[start..].char_indices() {
        match c {
            '{' => depth += 1,
            '}' => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return start + at + 1;
                }
            }
            ';' if depth == 0 => return start + at + 1,
            _ => {}
        }
    }
    code.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(text: &str) -> String {
        let words: Vec<String> =
            Source::new(text).code.split_whitespace().map(str::to_owned).collect();
        words.join(" ")
    }

    #[test]
    fn comments_and_literals_are_no_code() {
        assert_eq!(code("a // b\nc"), "a c");
        assert_eq!(code("a /* b /* c */ d */ e"), "a e");
        assert_eq!(code(r#"f("b // \" c") d"#), "f( ) d");
        assert_eq!(code("f(r#\"b \" c\"#) d"), "f( ) d");
        assert_eq!(code("f(br\"b\") d"), "f(b ) d");
    }

    #[test]
    fn lifetimes_are_code_and_characters_are_not() {
        assert_eq!(code("fn f<'a>(x: &'a str)"), "fn f<'a>(x: &'a str)");
        assert_eq!(code("f('\"') g"), "f( ) g");
        assert_eq!(code("f('\\'') g"), "f( ) g");
        assert_eq!(code("f('\\u{1F600}') g"), "f( ) g");
    }

    #[test]
    fn an_identifier_may_end_in_r() {
        assert_eq!(code("for\"x\" y"), "for y");
        assert_eq!(code("r#type = 1"), "r#type = 1");
    }

    #[test]
    fn lines_and_columns_stay() {
        let text = "a // b\n  \"é\" c\n";
        let source = Source::new(text);
        assert_eq!(source.code.lines().count(), 2);
        assert_eq!(source.code.lines().nth(1).unwrap().chars().position(|c| c == 'c'), Some(6));
        assert_eq!(source.comments.lines().next().unwrap(), "  // b");
    }

    #[test]
    fn test_modules_do_not_ship() {
        let source =
            Source::new("fn a() {}\n#[cfg(test)]\nmod tests { fn b() { { } } }\nfn c() {}");
        let shipped = source.shipped_code();
        assert!(shipped.contains("fn a") && shipped.contains("fn c"));
        assert!(!shipped.contains("fn b"));
        assert_eq!(shipped.lines().count(), 4);
    }

    #[test]
    fn broken_text_ends() {
        for text in ["\"", "'\\", "/*", "r#\"", "'", "\\", "#[cfg(test)] mod a {"] {
            Source::new(text).shipped_code();
        }
    }
}
