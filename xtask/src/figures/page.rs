//! Pages written by hand, with measured parts between marks.

use std::time::{SystemTime, UNIX_EPOCH};

/// `text` with what stands between the marks `name` replaced by `body`.
///
/// # Errors
/// Marks that are missing or stand in the wrong order.
pub fn replace(text: &str, name: &str, body: &str) -> Result<String, String> {
    let (open, close) = (format!("<!-- figures:{name} -->"), format!("<!-- /figures:{name} -->"));
    let missing = || format!("lacks the marks {open} and {close}");
    let begin = text.find(&open).ok_or_else(missing)? + open.len();
    let end = begin + text[begin..].find(&close).ok_or_else(missing)?;
    Ok(format!("{}\n{}\n{}", &text[..begin], body.trim_end(), &text[end..]))
}

/// The date of today, UTC, as `2026-11-22`.
pub fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    date(seconds / 86_400)
}

/// The date some days after 1970-01-01. Counted from a first of March, so that the leap day ends a
/// year, and in spans of 400 years, which are all alike.
fn date(days: u64) -> String {
    let days = days + 719_468;
    let (span, day_of_span) = (days / 146_097, days % 146_097);
    let leap = day_of_span / 1460 - day_of_span / 36_524 + day_of_span / 146_096;
    let year_of_span = (day_of_span - leap) / 365;
    let day_of_year = day_of_span - (365 * year_of_span + year_of_span / 4 - year_of_span / 100);
    let month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month + 2) / 5 + 1;
    let (month, carry) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    format!("{:04}-{month:02}-{day:02}", 400 * span + year_of_span + carry)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_stands_between_the_marks_changes() {
        let text = "a\n<!-- figures:x -->\nold\n<!-- /figures:x -->\nb <!-- figures:y -->";
        let new = replace(text, "x", "new\n").unwrap();
        assert_eq!(new, "a\n<!-- figures:x -->\nnew\n<!-- /figures:x -->\nb <!-- figures:y -->");
        assert_eq!(replace(&new, "x", "new").as_ref(), Ok(&new));
        assert!(replace(text, "y", "").is_err_and(|why| why.contains("figures:y")));
        assert!(replace(text, "z", "").is_err());
    }

    #[test]
    fn dates_around_leap_days_and_ends_of_years() {
        let known = [
            (0, "1970-01-01"),
            (58, "1970-02-28"),
            (59, "1970-03-01"),
            (364, "1970-12-31"),
            (11_016, "2000-02-29"),
            (11_017, "2000-03-01"),
            (19_782, "2024-02-29"),
            (20_779, "2026-11-22"),
            (47_540, "2100-02-28"),
            (47_541, "2100-03-01"),
        ];
        for (days, want) in known {
            assert_eq!(date(days), want, "{days}");
        }
    }
}
