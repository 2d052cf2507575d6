// Types and property sets of the objects of a design.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "building/ifc/design_relations.hpp"
#include "building/ifc/selection.hpp"

namespace plumbline::ifc {

class Properties {
 public:
  /// Keeps references; `length_unit` in metres. What is damaged is counted in `damage`.
  Properties(const Model& model, Damage& damage) : model_(model), damage_(damage) { read_types(); }

  /// Metres in one length unit of the file: lengths among the properties come in metres.
  double length_unit = 1;

  const std::string& type_name(std::uint64_t object) const;
  /// PredefinedType of its type, such as CURTAIN_PANEL; empty if it has none, or one that says nothing.
  std::string kind_of_type(std::uint64_t object) const;
  /// Looks up which sets these objects have, once and for all of them; without it objects have those of their types.
  void find_sets(const std::unordered_set<std::uint64_t>& objects);
  /// Its properties, those of the object before its type's: single and bounded values; of others the name only. A
  /// property of Pset_Tolerance that two sets of the object give differently is there twice.
  std::vector<Property> of(std::uint64_t object);

 private:
  void read_types();
  void add(std::uint64_t set, std::size_t before, std::vector<Property>& to);
  void add_quantities(const Entity& set, std::vector<Property>& to) const;
  bool read_single(const step::Value& value, Property& property) const;

  const Model& model_;
  Damage& damage_;
  std::uint64_t own_unit_ = 0;  // instance of the unit of the property at hand; 0: the project's
  std::unordered_map<std::uint64_t, std::string> type_names_;  // by type
  std::unordered_map<std::uint64_t, std::uint64_t> types_;     // by object
  std::unordered_map<std::uint64_t, std::vector<std::uint64_t>> sets_;
};

}  // namespace plumbline::ifc
