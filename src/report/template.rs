//! Pages are templates whose gaps, written `{{name}}`, are filled.

/// `template` with its gaps filled by `parts`, name and text; a gap without a part stays empty.
///
/// Piece by piece, not by replacing: a title may spell a gap's name.
pub fn fill(template: &str, parts: &[(&str, &str)]) -> String {
    let mut page =
        String::with_capacity(template.len() + parts.iter().map(|(_, text)| text.len()).sum::<usize>());
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        page.push_str(before);
        page.push_str(parts.iter().find(|(known, _)| *known == name).map_or("", |(_, text)| text));
        rest = after;
    }
    page.push_str(rest);
    page
}

/// Names of the gaps in `template`, in order.
#[cfg(test)]
pub fn gaps(template: &str) -> Vec<&str> {
    template.split("{{").skip(1).filter_map(|rest| rest.split("}}").next()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_spells_a_gap_is_not_filled() {
        let page = fill("<{{a}}|{{b}}|{{c}}>", &[("a", "{{b}}"), ("b", "2")]);
        assert_eq!(page, "<{{b}}|2|>");
    }
}
