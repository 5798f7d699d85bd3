//! The list of objects: a tree of nodes, and which are drawn.

use super::{MARGIN, WIDTH, half, height};
use crate::command::view::viewer::Viewer;
use egui::{Context, ScrollArea, TextEdit, Window, vec2};
use rtrt::import::Label;
use std::ops::Range;

/// A row of the list.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Row {
    depth: usize,
    name: String,
    /// The objects in it.
    objects: Range<u32>,
    /// Whether it is one object, and no node above.
    is_object: bool,
}

/// The rows of a scene, made once.
#[derive(Debug, Default)]
pub struct Rows {
    rows: Vec<Row>,
    /// What they were made of: [`rtrt_core::scene::Scene::id`], and the number of objects.
    of: Option<(u32, usize)>,
    filter: String,
}

/// Shows the list, and applies changes.
pub fn show(context: &Context, viewer: &mut Viewer, list: &mut Rows) {
    let of = (viewer.job.scene.id(), viewer.job.scene.instances().len());
    if list.of != Some(of) {
        *list = Rows { rows: rows(&viewer.job.labels, of.1), of: Some(of), filter: String::new() };
    }
    let mut is_open = viewer.settings.objects;
    let corner = context.content_rect().left_top() + vec2(MARGIN, MARGIN);
    let window = Window::new("objects").open(&mut is_open).default_width(WIDTH).default_pos(corner);
    let most = if viewer.shows_selection() { half(context) } else { height(context) };
    window.max_height(most).show(context, |ui| {
        ui.add(TextEdit::singleline(&mut list.filter).hint_text("find"));
        let wanted = list.filter.to_lowercase();
        let is_found = |row: &&Row| wanted.is_empty() || row.name.to_lowercase().contains(&wanted);
        let found: Vec<&Row> = list.rows.iter().filter(is_found).collect();
        let line = ui.spacing().interact_size.y;
        ScrollArea::both().auto_shrink([false, true]).show_rows(ui, line, found.len(), |ui, range| {
            for row in &found[range] {
                ui.horizontal(|ui| {
                    ui.add_space(12.0 * row.depth as f32);
                    let mut is_visible = row.objects.clone().any(|object| viewer.is_visible(object));
                    if ui.checkbox(&mut is_visible, "").changed() {
                        viewer.show_objects(row.objects.clone(), is_visible);
                    }
                    let selected = viewer.selection.as_ref().map(|selection| selection.object);
                    let is_selected = row.is_object && selected == Some(row.objects.start);
                    if ui.selectable_label(is_selected, &row.name).clicked() && row.is_object {
                        viewer.select(row.objects.start);
                    }
                });
            }
        });
    });
    viewer.settings.objects = is_open;
}

/// The rows of so many objects with these labels. Objects that follow one another below the same node are in it.
fn rows(labels: &[Label], count: usize) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    // The rows of the nodes above.
    let mut above: Vec<usize> = Vec::new();
    for object in 0..count as u32 {
        let label = labels.get(object as usize).cloned().unwrap_or_default();
        let path: Vec<&str> = label.path.split_terminator('/').collect();
        let same = above.iter().zip(&path).take_while(|(row, name)| rows[**row].name == **name).count();
        above.truncate(same);
        for name in &path[same..] {
            above.push(rows.len());
            let (name, objects) = ((*name).to_owned(), object..object);
            rows.push(Row { depth: above.len() - 1, name, objects, is_object: false });
        }
        above.iter().for_each(|row| rows[*row].objects.end = object + 1);
        let name = match (&*label.node, &*label.mesh) {
            ("", "") => format!("object {object}"),
            (node, "") => node.to_owned(),
            (node, mesh) if node == mesh => node.to_owned(),
            (node, mesh) => format!("{node} ({mesh})"),
        };
        rows.push(Row { depth: path.len(), name, objects: object..object + 1, is_object: true });
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn label(path: &str, node: &str, mesh: &str) -> Label {
        Label { path: path.into(), node: node.into(), mesh: mesh.into(), ..Label::default() }
    }

    #[test]
    fn objects_are_below_their_nodes() {
        let labels =
            [label("a/b/", "c", "m"), label("a/", "d", "d"), label("e/", "", ""), label("a/", "f", "")];
        let rows = rows(&labels, 5);
        let seen: Vec<_> =
            rows.iter().map(|row| (row.depth, &*row.name, row.objects.clone(), row.is_object)).collect();
        let wanted = [
            (0, "a", 0..2, false),
            (1, "b", 0..1, false),
            (2, "c (m)", 0..1, true),
            (1, "d", 1..2, true),
            (0, "e", 2..3, false),
            (1, "object 2", 2..3, true),
            (0, "a", 3..4, false),
            (1, "f", 3..4, true),
            (0, "object 4", 4..5, true),
        ];
        assert_eq!(seen, wanted);
    }
}
