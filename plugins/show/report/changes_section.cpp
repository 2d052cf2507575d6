// Since the campaign before: what was mended, what opened again, what has moved, what nobody has measured again.
#include <algorithm>
#include <array>
#include <cmath>

#include "building/judgement/epochs.hpp"
#include "show/report/format.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// Of thousands; as_built.json holds all.
constexpr std::size_t kMostChanges = 308;

bool was_open(const AsBuiltChangeT& c) {
  return c.before == ToleranceVerdict::fail || c.before == ToleranceVerdict::undecided;
}

/// What somebody has to look at stands first; -1: not listed.
int rank_of(const AsBuiltChangeT& c) {
  switch (c.change) {
    case ChangeKind::opened_again:
      return 0;
    case ChangeKind::opened:
      return 1;
    case ChangeKind::still_open:
      return 3;
    case ChangeKind::unseen:
      return was_open(c) ? 4 : -1;
    case ChangeKind::left_out:
      return 5;
    case ChangeKind::mended:
      return 6;
    case ChangeKind::settled:
      return 7;
    default:
      return c.moved ? 2 : -1;  // in order, and not where it was
  }
}

std::string kind_of(const AsBuiltChangeT& c) {
  return c.kind == "anchor" ? "Anchor " : c.kind == "panel" ? "Panel " : c.kind == "surface" ? "Surface " : "Joint ";
}

std::string movement_of(const AsBuiltChangeT& c) {
  if (!c.topic.empty() && std::isfinite(c.value_before) && std::isfinite(c.value))
    return mm(c.value_before, 1) + " → " + mm(c.value, 1) + "\u00A0mm";
  if (!c.movement.allFinite()) return unknown;
  std::string text = mm(c.movement.norm(), 1);
  if (std::isfinite(c.u)) text += " ± " + mm(c.u, 1);
  text += "\u00A0mm (" + signed_mm(c.movement.x(), 1) + ", " + signed_mm(c.movement.y(), 1) + ", " +
          signed_mm(c.movement.z(), 1) + ")";
  return c.moved ? "moved " + text : text;
}

}  // namespace

std::string since(const AsBuiltChangesT& changes) {
  return "Since " + (changes.before.empty() ? std::string("the campaign before") : changes.before);
}

void write_changes(Markup& html, const AsBuiltChangesT& changes) {
  if (!changes.compared) return;
  std::vector<const AsBuiltChangeT*> rows;
  for (const auto& change : changes.changes)
    if (rank_of(*change) >= 0) rows.push_back(change.get());
  std::stable_sort(rows.begin(), rows.end(),
                   [](const AsBuiltChangeT* a, const AsBuiltChangeT* b) { return rank_of(*a) < rank_of(*b); });
  Scope part(html, "section", {{"id", "changes"}});
  html.element("h2", since(changes));
  html.element("p", judgement::words_of_changes(changes) + "; " +
                        count(changes.measured_twice, "anchor was", "anchors were") +
                        " measured in both campaigns. Their movements are tested as if nothing were common to the "
                        "campaigns: one that is told is one, a small one may be missed.");
  for (const std::string& warning : changes.warnings) html.element("p", {{"class", "note"}}, warning + ".");
  if (rows.empty()) return;
  const std::size_t listed = std::min(kMostChanges, rows.size());
  {
    Scope wide(html, "div", {{"class", "wide"}});
    Scope table(html, "table", {{"class", "sortable"}});
    table_head(html, {left("Where"), "Floor", left("Before"), left("Now"), left("What became of it"),
                      left("Movement (x, y, z), or the value")});
    Scope body(html, "tbody");
    for (std::size_t i = 0; i < listed; ++i) {
      const AsBuiltChangeT& c = *rows[i];
      const PlacedRow row(html, c.floor, c.facade, c.after);
      html.element("th", {{"scope", "row"}}, kind_of(c) + c.id);
      html.element("td", {{"data-head", "Floor"}}, c.floor > 0 ? std::to_string(c.floor) : unknown);
      verdict_cell(html, c.before);
      verdict_cell(html, c.after);
      html.element("td", {{"class", "text"}},
                   std::string(judgement::words_of(c.change)) + (c.note.empty() ? "" : ": " + c.note));
      html.element("td", {{"class", "words"}}, movement_of(c));
    }
  }
  if (listed < rows.size()) html.element("p", std::to_string(rows.size() - listed) + " more stand in as_built.json.");
}

}  // namespace plumbline::report
