// Elements of the design by their GlobalIds, and which of them are panels to hang.
#pragma once

#include <map>
#include <set>
#include <string>

#include "artifacts/design.hpp"

namespace plumbline::loop {

/// Refers to the design.
struct DesignElements {
  std::map<std::string, const DesignElementT*> by_guid;
  std::set<std::string> wholes;  ///< GlobalIds of what panels are parts of (a curtain wall of plates)

  explicit DesignElements(const DesignT& design) {
    for (const auto& element : design.elements) by_guid[element->guid] = element.get();
    for (const auto& [guid, element] : by_guid)
      if (element->is_panel) wholes.insert(element->parent_guid);
  }

  /// Null where the design has none.
  const DesignElementT* find(const std::string& guid) const {
    const auto element = by_guid.find(guid);
    return element == by_guid.end() ? nullptr : element->second;
  }

  std::string tag_of(const std::string& guid) const {
    const DesignElementT* element = find(guid);
    return element ? element->tag : std::string();
  }

  /// A panel that is hung, and no whole made of others.
  bool is_panel(const DesignElementT& element) const { return element.is_panel && !wholes.contains(element.guid); }
};

}  // namespace plumbline::loop
