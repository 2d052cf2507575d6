#include "build/evaluate/unused_row.hpp"

#include <algorithm>
#include <set>
#include <vector>

#include "base/text/near_text.hpp"
#include "building/ifc/ifc_schema.hpp"

namespace plumbline::judgement {
namespace {

using Term = ifc::Selection::Term;

/// Anchors and panels of a design, as terms look at them.
class Elements {
 public:
  explicit Elements(const DesignT& design) {
    for (const auto& element : design.elements)
      if (element->is_anchor || element->is_panel) elements_.push_back(element.get());
  }

  bool any(const Term& term) const {
    return std::any_of(elements_.begin(), elements_.end(), [&](const DesignElementT* element) {
      std::vector<ifc::Property> properties;
      if (term.key.find('.') != std::string::npos)
        for (const auto& p : element->properties)
          properties.push_back({p->set, p->name, p->text, p->number, p->measure, p->lower, p->upper, p->holder});
      const ifc::ElementFacts facts{element->class_,      element->guid,      element->name,   element->tag,
                                    element->object_type, element->type_name, element->storey, &properties};
      return ifc::Selection::matches(term, facts);
    });
  }

  /// What they have in place of a term's value.
  std::vector<std::string> values(const std::string& key) const {
    std::set<std::string> all;
    for (const DesignElementT* element : elements_) {
      if (key == "class") all.insert(element->class_);
      if (key == "storey") all.insert(element->storey);
      if (key == "name") all.insert(element->name);
      if (key == "tag") all.insert(element->tag);
      if (key == "type") all.insert({element->type_name, element->object_type});
      for (const auto& p : element->properties)
        if (key == p->set + "." + p->name) all.insert(p->text);
    }
    all.erase("");
    return {all.begin(), all.end()};
  }

 private:
  std::vector<const DesignElementT*> elements_;
};

bool is_class(const std::string& name) {
  const auto classes = ifc::element_classes();
  return std::any_of(classes.begin(), classes.end(), [&](const auto& one) { return one.name == name; });
}

/// A class that these are a kind of by name: "IfcMechanicalFastener" of "IfcFastener"; empty: none.
std::string kind_of(const std::string& name, const std::vector<std::string>& classes) {
  const std::string stem = name.substr(std::min<std::size_t>(3, name.size()));  // behind "Ifc"
  const auto found = std::find_if(classes.begin(), classes.end(), [&](const std::string& one) {
    return !stem.empty() && one != name && one.find(stem) != std::string::npos;
  });
  return found == classes.end() ? std::string() : *found;
}

std::string why_of(const Term& term, const Elements& elements) {
  if (elements.any(term)) return "";
  if (term.expression)
    return "no anchor and no panel has a " + term.key + " in which '" + term.value + "' finds anything";
  const std::vector<std::string> values = elements.values(term.key);
  std::string near = term.key == "class" ? kind_of(term.value, values) : std::string();
  if (near.empty() && term.key == "class" && is_class(term.value)) return "";
  if (std::any_of(values.begin(), values.end(),
                  [&](const std::string& value) { return text::differ_in_figures_alone(value, term.value); }))
    return "";
  if (near.empty()) near = text::nearest_of(term.value, values);
  return "no anchor and no panel has the " + term.key + " '" + term.value + "'" +
         (near.empty() ? "" : ", the nearest here is '" + near + "'");
}

}  // namespace

std::string why_unused(const ToleranceRule& row, const DesignT& design) {
  if (row.optional) return "";
  const Elements elements(design);
  std::string why;
  for (const Term& term : row.selection.terms())
    if (const std::string one = why_of(term, elements); !one.empty()) why += (why.empty() ? "" : "; ") + one;
  return why.empty() ? why : why + "; a row for other buildings says 'yes' in the column 'optional'";
}

}  // namespace plumbline::judgement
