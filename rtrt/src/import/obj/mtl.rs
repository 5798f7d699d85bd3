//! MTL: the materials of an OBJ file.

use super::parse::{lines, numbers};
use rtrt_core::layout::COLOR_LIMIT;

/// A material as the file has it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Source {
    pub name: String,
    pub diffuse: [f32; 3],
    pub specular: [f32; 3],
    pub shininess: f32,
    pub emission: [f32; 3],
    /// How much of it covers what is behind it, 0 ..= 1.
    pub alpha: f32,
    /// The file of the diffuse texture.
    pub texture: Option<String>,
    /// Whether the texture's edge goes on instead of the texture repeating.
    pub clamp: bool,
}

/// The materials in the file. Lines that it does not know, and colors that are not three
/// numbers, are passed over: a material is never a reason to draw nothing.
pub(super) fn parse(bytes: &[u8]) -> Vec<Source> {
    let mut materials: Vec<Source> = Vec::new();
    // `Tr` is what `d` leaves; where both are given, `d` is meant.
    let mut has_d = false;
    for (_, line) in lines(bytes) {
        let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((&line, ""));
        let rest = rest.trim();
        if key == "newmtl" {
            has_d = false;
            materials.push(Source {
                name: rest.to_owned(),
                diffuse: [0.8; 3],
                specular: [0.0; 3],
                shininess: 1.0,
                emission: [0.0; 3],
                alpha: 1.0,
                texture: None,
                clamp: false,
            });
        }
        let Some(material) = materials.last_mut() else { continue };
        match key.to_ascii_lowercase().as_str() {
            "kd" => color(rest, &mut material.diffuse),
            "ks" => color(rest, &mut material.specular),
            "ke" => color(rest, &mut material.emission),
            "ns" => {
                let shininess = numbers(rest).map_or(1.0, |n| n.first());
                material.shininess = if shininess >= 1.0 { shininess.min(8192.0) } else { 1.0 };
            }
            "d" => {
                has_d = true;
                material.alpha = share(rest).unwrap_or(1.0);
            }
            // Some programs write `Tr 1` for what is opaque.
            "tr" if !has_d => material.alpha = share(rest).filter(|&tr| tr < 1.0).map_or(1.0, |tr| 1.0 - tr),
            "map_kd" => (material.texture, material.clamp) = texture(rest),
            _ => {}
        }
    }
    materials
}

/// A number within 0 ..= 1.
fn share(rest: &str) -> Option<f32> {
    let share = numbers(rest).ok().filter(|n| n.count == 1)?.first();
    share.is_finite().then(|| share.clamp(0.0, 1.0))
}

/// One number is gray. Anything else than numbers (`spectral`, `xyz`) leaves what is there.
fn color(rest: &str, color: &mut [f32; 3]) {
    let Ok(n) = numbers(rest) else { return };
    let values = if n.count == 1 { [n.first(); 3] } else { [n.first(), n.second(), n.third()] };
    if (n.count == 1 || n.count == 3) && values.iter().all(|v| v.is_finite()) {
        *color = values.map(|v| v.clamp(0.0, COLOR_LIMIT));
    }
}

/// The file's name behind the options, and whether `-clamp on` is one of them.
fn texture(rest: &str) -> (Option<String>, bool) {
    let (mut rest, mut clamp) = (rest, false);
    while let Some((option, after)) = rest.strip_prefix('-').and_then(|r| r.split_once(char::is_whitespace)) {
        // Options with numbers have one to three; the rest have one word.
        let (least, most) = match option {
            "o" | "s" | "t" => (1, 3),
            "mm" => (2, 2),
            _ => (1, 1),
        };
        let mut left = after.trim_start();
        for number in 0..most {
            let (word, after) = left.split_once(char::is_whitespace).unwrap_or((left, ""));
            if number >= least && word.parse::<f32>().is_err() {
                break;
            }
            clamp |= option == "clamp" && word == "on";
            left = after.trim_start();
        }
        rest = left;
    }
    ((!rest.is_empty()).then(|| rest.to_owned()), clamp)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texture_follows_its_options() {
        let name = |rest| texture(rest).0.unwrap();
        assert_eq!(name("a b.png"), "a b.png");
        assert_eq!(name("-s 2 2 1 -o 0.5 wood.jpg"), "wood.jpg");
        assert_eq!(texture("-clamp on x.png"), (Some("x.png".into()), true));
        assert_eq!(texture(""), (None, false));
    }

    #[test]
    fn d_is_alpha_and_tr_what_it_leaves() {
        let alpha = |text: &str| parse(format!("newmtl a\n{text}").as_bytes())[0].alpha;
        assert_eq!([alpha("d 0.25"), alpha("Tr 0.25"), alpha("d 0.5\nTr 0.9")], [0.25, 0.75, 0.5]);
        assert_eq!([alpha("Tr 1"), alpha("d nan"), alpha("d 7"), alpha("d")], [1.0; 4]);
    }

    #[test]
    fn broken_lines_keep_the_defaults() {
        let materials = parse(b"Kd 1 1 1\nnewmtl a b\nKd spectral x\nKs nan 0 0\nNs -3\nKe 0.5\n");
        assert_eq!(materials.len(), 1);
        assert_eq!((materials[0].name.as_str(), materials[0].diffuse), ("a b", [0.8; 3]));
        assert_eq!((materials[0].shininess, materials[0].emission), (1.0, [0.5; 3]));
    }
}
