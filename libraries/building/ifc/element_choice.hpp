// Which elements of a design are anchors, and which are panels.
#pragma once

#include <regex>
#include <string>
#include <unordered_set>
#include <vector>

#include "building/ifc/design.hpp"
#include "building/ifc/ifc_model.hpp"

namespace plumbline::ifc {

/// The element's own PredefinedType, behind Tag in every schema; IFC2X3 has none for plates. Empty where it says
/// nothing.
std::string own_kind(const Entity& entity);

class ElementChoice {
 public:
  /// `rule` outlives it. Throws step::Error if the pattern is no regular expression, and what a selection throws that
  /// cannot be read.
  explicit ElementChoice(const AnchorRule& rule);

  /// Whether properties have to be known before a choice.
  bool needs_properties() const;
  bool is_anchor(const Element& element);
  /// Those of the user alone, if he names any; else plates, cladding and curtain walls by class and `kind`, the
  /// PredefinedType.
  bool is_panel(const Element& element, const std::string& kind);
  /// Whether a panel takes the place of walls as panels.
  bool is_cladding(const Element& element, const std::string& kind) const;
  /// What was named as an anchor or a panel and is nothing.
  void tell_idle(Design& design) const;

 private:
  const AnchorRule& rule_;
  std::regex pattern_;
  std::unordered_set<std::string> names_, guids_;
  std::vector<Selection> selections_, panel_selections_;
  std::vector<bool> selecting_, selecting_panels_;  // those of them that select something
};

}  // namespace plumbline::ifc
