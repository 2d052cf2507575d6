// The language that names elements of a design, the same for reader, matcher and judgement:
//
//   class=IfcMechanicalFastener
//   name~^F0[1-3]-           a regular expression (ECMAScript) that finds something
//   class=IfcPlate & storey=Level 2
//   Pset_Tolerance.ToleranceBasis=ASSEMBLY
//   *
//
// Keys: class, guid, name, tag, type (name of the type or ObjectType), storey, batch (of the plate, where there is
// one), or Set.Property. Terms are joined by '&'.
#pragma once

#include <limits>
#include <regex>
#include <string>
#include <vector>

namespace plumbline::ifc {

/// A property of an element. `number` is nan if the value is none; lengths in metres.
struct Property {
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::string set, name, text;
  double number = 0;
  std::string measure = {};  ///< type of the value, such as IFCLENGTHMEASURE; of what is no single value, its keyword
  double lower = nan, upper = nan;  ///< of a bounded value, like `number`
  /// What has it in the element's place, such as "IfcBuildingStorey 'Floor 2'"; empty: the element, or its type. Only
  /// of sets about tolerances, and no term of a selection looks at it.
  std::string holder = {};
};

/// What a selection looks at.
struct ElementFacts {
  std::string ifc_class, guid, name, tag, object_type, type_name, storey;
  const std::vector<Property>* properties = nullptr;  ///< null: none
  std::string batch = {};                             ///< of the plate at this anchor
};

/// Something that was asked for and could not be done: then nothing is ready to install.
struct NotApplied {
  std::string asked, by, reason;
};

class Selection {
 public:
  /// Throws std::runtime_error that names the term for a key that is not known or an impossible regular expression.
  explicit Selection(const std::string& text);

  bool matches(const ElementFacts& element) const;
  /// Whether any term looks at a property.
  bool needs_properties() const;
  const std::string& text() const { return text_; }

  struct Term {
    std::string key, value;
    bool expression = false;
    std::regex pattern;
  };
  /// None of '*'.
  const std::vector<Term>& terms() const { return terms_; }
  static bool matches(const Term& term, const ElementFacts& element);

 private:
  std::string text_;
  std::vector<Term> terms_;
};

}  // namespace plumbline::ifc
