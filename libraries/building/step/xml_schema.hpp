// What ifcXML leaves to the schema: the order of an entity's attributes, their types, and what inverts what.
// Private to libraries/building/step.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::step {

std::string capitals(std::string_view name);

/// An EXPRESS schema as scripts/express_attributes writes it. Types are told as there: s r i b l x e ?, "[n]T" for
/// lists of T (n 0 unless it is always the same), else the name of a type or entity.
class XmlSchema {
 public:
  struct Attribute {
    std::string_view name, type;
    bool derived = false;  ///< written as * in STEP
  };
  struct Inverse {
    std::string_view name, entity, forward;  ///< `forward` of `entity` refers to who has the inverse
  };
  struct Entity {
    std::string_view name;
    bool is_abstract = false;
    std::vector<Attribute> attributes;  ///< in the order of STEP, inherited ones first
    std::vector<Inverse> inverses;

    const Attribute* attribute(std::string_view wanted) const;
    const Inverse* inverse(std::string_view wanted) const;
  };

  /// "IFC2X3", "IFC4" or "IFC4X3".
  explicit XmlSchema(const std::string& name);

  const std::string& name() const { return name_; }
  /// By name, in whatever case exporters write it; null if there is none. Stays where it is.
  const Entity* entity(std::string_view name);
  /// The name of a defined type as the schema spells it; empty if there is none.
  std::string_view defined_type(std::string_view name) const;
  /// What a type comes down to: a letter, a list, or the name of an entity.
  std::string_view resolved(std::string_view type) const;

 private:
  struct Line {
    std::string_view name, rest;
    bool is_abstract = false;
  };
  std::string name_;
  std::map<std::string, Line, std::less<>> types_, lines_;  // by name in capitals
  std::map<std::string, Entity, std::less<>> entities_;     // those that were asked for
};

}  // namespace plumbline::step
