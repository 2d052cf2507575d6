#include "building/ifc/match_elements.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <unordered_map>

#include "base/text/bare_name.hpp"
#include "base/text/composed.hpp"
#include "building/ifc/rule_use.hpp"
#include "building/ifc/selection_rule.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::ifc {
namespace {

std::string value_of(const Element& element, const std::string& key) {
  if (key == "guid") return element.guid;
  if (key == "tag") return element.tag;
  if (key == "name") return element.name;
  const std::size_t dot = key.find('.');
  if (dot == std::string::npos)
    throw std::runtime_error("match: found the key '" + key + "', expected guid, tag, name or Set.Property");
  for (const Property& property : element.properties)
    if (property.set == key.substr(0, dot) && property.name == key.substr(dot + 1)) return property.text;
  return "";
}

/// Levenshtein distance, at most 3.
int distance(const std::string& a, const std::string& b) {
  if (a.size() > b.size() + 2 || b.size() > a.size() + 2 || a.size() > 100) return 3;
  std::vector<int> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])});
      diagonal = above;
    }
  }
  return std::min(row[b.size()], 3);
}

std::string words_of(const Element& element) {
  return element.ifc_class + " '" + element.name + "'" + (element.tag.empty() ? "" : ", Tag '" + element.tag + "'") +
         " (" + element.guid + ")";
}

std::string list_of(const std::vector<const Element*>& elements) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(elements.size(), 3); ++i)
    text += (i ? "; " : "") + words_of(*elements[i]);
  return text + (elements.size() > 3 ? "; and " + std::to_string(elements.size() - 3) + " more" : "");
}

class Matcher {
 public:
  Matcher(const Design& design, const MatchOptions& options) : design_(design), options_(options) {
    for (const std::string& key : options.by) {
      auto& index = index_[key];
      for (const Element& element : design.elements)
        if (const std::string value = value_of(element, key); !value.empty())
          index[text::composed(value)].push_back(&element);  // "ü" may be one character or two
    }
    for (const MappingRow& row : options.mapping) mapping_[row.point].push_back(&row);
  }

  MatchedElement match(const std::string& anchor) const {
    MatchedElement found;
    found.anchor = anchor;
    if (const auto rows = mapping_.find(anchor); rows != mapping_.end()) {
      if (rows->second.size() > 1) {
        found.note = "the mapping table has it in lines " + std::to_string(rows->second[0]->line) + " and " +
                     std::to_string(rows->second[1]->line);
        return found;
      }
      const MappingRow& row = *rows->second[0];
      resolve(row.element, found);
      if (found.element) found.found_by = "mapping";
      if (!found.element)
        found.note =
            "line " + std::to_string(row.line) + " of the mapping table leads to '" + row.element + "': " + found.note;
    } else {
      resolve(anchor, found);
    }
    if (found.element) place(found);
    return found;
  }

 private:
  void resolve(const std::string& id, MatchedElement& found) const {
    std::vector<const Element*> ambiguous;
    std::string ambiguous_key;
    for (const std::string& key : options_.by) {
      const auto entry = index_.at(key).find(text::composed(id));
      if (entry == index_.at(key).end()) continue;
      std::vector<const Element*> candidates = entry->second;
      if (candidates.size() > 1 &&
          std::any_of(candidates.begin(), candidates.end(), [](const Element* e) { return e->is_anchor; }))
        std::erase_if(candidates, [](const Element* element) { return !element->is_anchor; });
      if (candidates.size() > 1) {
        if (ambiguous.empty()) ambiguous = candidates, ambiguous_key = key;
        continue;
      }
      if (found.element && found.element != candidates[0]) {
        found.note = "its " + found.found_by + " is that of " + words_of(*found.element) + ", its " + key +
                     " that of " + words_of(*candidates[0]) + "; say in a mapping table which is meant";
        found.element = nullptr, found.found_by.clear();
        return;
      }
      if (!found.element) found.element = candidates[0], found.found_by = key;
    }
    if (found.element) return;
    if (!ambiguous.empty())
      found.note = std::to_string(ambiguous.size()) + " elements have this " + ambiguous_key + ": " +
                   list_of(ambiguous) + "; name them by GlobalId or Tag, or give a mapping table";
    else
      found.note = "no element has this " + keys() + near_misses(id);
  }

  std::string keys() const {
    std::string text;
    for (std::size_t i = 0; i < options_.by.size(); ++i)
      text += (i == 0 ? "" : i + 1 < options_.by.size() ? ", " : " or ") + options_.by[i];
    return text;
  }

  std::string near_misses(const std::string& id) const {
    const std::string own = text::bare_name(id);
    std::vector<const Element*> alike, cut, close;
    for (const Element& element : design_.elements)
      for (const std::string& key : options_.by) {
        const std::string value = value_of(element, key);
        if (value.empty() || own.empty()) continue;
        const std::string other = text::bare_name(value);
        auto* list = other == own ? &alike
                     : (id.size() == 8 || id.size() == 16) && value.size() > id.size() &&
                             (value.starts_with(id) || value.ends_with(id))
                         ? &cut
                     : element.is_anchor && own.size() > 3 && distance(own, other) <= 2 ? &close
                                                                                        : nullptr;
        if (!list) continue;
        list->push_back(&element);
        break;
      }
    if (!alike.empty()) return "; but for case, separators or leading zeros it is " + list_of(alike);
    if (!cut.empty())
      return "; it has the " + std::to_string(id.size()) + " characters of a GSI file, cut off from " + list_of(cut) +
             ": give a mapping table";
    if (!close.empty()) return "; near to it: " + list_of(close);
    return "";
  }

  void place(MatchedElement& found) const {
    const Element& element = *found.element;
    const ElementFacts facts = facts_of(element);
    found.reference = element.position, found.reference_rule = name_of(element.rule);
    for (const ReferencePoint& reference : options_.references) {
      if (!reference.selection.matches(facts)) continue;
      found.reference = reference_point(element, reference.rule), found.reference_rule = reference.rule;
    }
    for (const TargetOffset& offset : options_.offsets) {
      if (!offset.selection.matches(facts)) continue;
      found.target_offset = element.project_from_element.rotation * offset.own;
      if (offset.out == 0 && offset.right == 0 && offset.up == 0) continue;
      const FacadeFrame& frame = facade(element, offset.selection.text());
      found.target_offset += offset.out * frame.out + offset.right * frame.right + offset.up * frame.up;
    }
  }

  /// A direction that is only guessed would put the target on the wrong side.
  const FacadeFrame& facade(const Element& element, const std::string& rule) const {
    if (element.facade.known() && element.facade.confirmed) return element.facade;
    throw std::runtime_error(
        "'" + rule + "' asks for a place on the facade, but " +
        (element.facade.known()
             ? "which way " + words_of(element) + " faces is not confirmed: " + element.facade.note
             : "nothing in " + design_.file_name + " says which way " + words_of(element) + " faces") +
        "; say it with design.with.facades, such as ['class=" + element.ifc_class +
        ": azimuth=180deg'], or give the offset in the element's axes (x, y, z)");
  }

  Eigen::Vector3d reference_point(const Element& element, const std::string& rule) const {
    if (rule == "placement") return element.project_from_element.translation;
    if (!element.has_box) return element.position;
    const Eigen::Vector3d middle =
        element.project_from_element * Eigen::Vector3d(0.5 * (element.box_low + element.box_high));
    if (rule == "middle") return middle;
    const Eigen::Vector3d& out = facade(element, rule).out;
    const Eigen::Vector3d own = element.project_from_element.rotation.conjugate() * out;
    const Eigen::Vector3d half = 0.5 * (element.box_high - element.box_low);
    return middle + own.cwiseAbs().dot(half) * out;
  }

  const Design& design_;
  const MatchOptions& options_;
  std::map<std::string, std::unordered_map<std::string, std::vector<const Element*>>> index_;
  std::map<std::string, std::vector<const MappingRow*>> mapping_;
};

}  // namespace

TargetOffset parse_offset(const std::string& text) {
  const char* example = "class=IfcMechanicalFastener: out=40mm, up=-5mm";
  auto [selection, lengths, whole] = parse_lengths(text, example);
  TargetOffset offset{std::move(selection), 0, 0, 0, Eigen::Vector3d::Zero(), whole};
  const std::map<std::string, double*> places = {{"out", &offset.out},   {"right", &offset.right},
                                                 {"up", &offset.up},     {"x", &offset.own.x()},
                                                 {"y", &offset.own.y()}, {"z", &offset.own.z()}};
  for (const auto& [name, length, part] : lengths) {
    const auto place = places.find(name);
    if (place == places.end() || std::isnan(length))
      throw std::runtime_error("target offset '" + text + "': found '" + part +
                               "', expected out, right, up, x, y or z with a length in mm or m, such as '" + example +
                               "'");
    *place->second = length;
  }
  return offset;
}

ReferencePoint parse_reference(const std::string& text) {
  auto [selection, rule] = split_rule(text, "class=IfcMechanicalFastener: head");
  if (rule != "placement" && rule != "middle" && rule != "head")
    throw std::runtime_error("reference point '" + text + "': found '" + rule +
                             "', expected placement, middle or head");
  return {std::move(selection), std::move(rule), text};
}

namespace {

/// Rules that no anchor was placed by.
template <typename Rule>
void add_idle_rules(const std::vector<MatchedElement>& matches, const std::vector<Rule>& rules, const char* by,
                    std::vector<NotApplied>& to) {
  RuleUse use(rules.size());
  for (const MatchedElement& match : matches) {
    if (!match.element) continue;
    const std::vector<std::size_t> placed_by = selecting(rules, facts_of(*match.element));
    use.select(placed_by, match.anchor);
    use.apply(placed_by, last_of(placed_by));
  }
  const std::vector<std::string> texts = texts_of(rules);
  for (std::size_t i = 0; i < rules.size(); ++i)
    if (const std::string why = use.not_applied(i, texts, "anchors", "it selects no anchor of the plate table");
        !why.empty())
      to.push_back({rules[i].text, by, why});
}

}  // namespace

std::vector<MatchedElement> match_elements(const Design& design, const std::vector<std::string>& anchors,
                                           const MatchOptions& options, std::vector<std::string>& warnings,
                                           std::vector<NotApplied>* not_applied) {
  const Matcher matcher(design, options);
  std::vector<MatchedElement> matches;
  std::map<const Element*, std::size_t> taken;
  for (const std::string& anchor : anchors) {
    stop_point();
    matches.push_back(matcher.match(anchor));
    MatchedElement& found = matches.back();
    if (!found.element) continue;
    const auto [other, added] = taken.emplace(found.element, matches.size() - 1);
    if (added) continue;
    const std::string note =
        "'" + matches[other->second].anchor + "' and '" + found.anchor + "' are both " + words_of(*other->first);
    for (MatchedElement* both : {&matches[other->second], &found})
      both->note = note, both->element = nullptr, both->found_by.clear();
  }
  std::size_t unmatched = 0;
  std::string first;
  for (const MatchedElement& match : matches) {
    if (match.element) continue;
    if (unmatched++ == 0) first = "'" + match.anchor + "': " + match.note;
    if (unmatched <= 10) warnings.push_back("anchor '" + match.anchor + "': " + match.note);
  }
  if (unmatched > 10) warnings.push_back(std::to_string(unmatched - 10) + " more anchors fit no element of the design");
  if (not_applied) {
    add_idle_rules(matches, options.offsets, "offset", *not_applied);
    add_idle_rules(matches, options.references, "reference_point", *not_applied);
  }
  const std::set<std::string> known(anchors.begin(), anchors.end());
  for (const MappingRow& row : options.mapping)
    if (!known.contains(row.point))
      warnings.push_back("line " + std::to_string(row.line) + " of the mapping table: the plate table has no anchor '" +
                         row.point + "'");
  if (!matches.empty() && unmatched == matches.size())
    throw std::runtime_error("none of the " + std::to_string(matches.size()) +
                             " anchors of the plate table is an element of " + design.file_name + "; the first, " +
                             first);
  return matches;
}

}  // namespace plumbline::ifc
