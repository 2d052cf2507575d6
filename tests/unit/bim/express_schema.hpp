// An EXPRESS schema as far as instances can be held against it: entities with their attributes and types. Test support.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "building/step/step.hpp"

namespace plumbline::test {

struct ExpressType {
  enum class Form { simple, named, aggregate, enumeration, select } form = Form::simple;
  std::string name;                      // simple: REAL …; named: the type or entity, in capitals
  int minimum = 0;                       // of an aggregate
  std::vector<std::string> members;      // of an enumeration or select, in capitals
  std::shared_ptr<ExpressType> element;  // of an aggregate
};

struct ExpressAttribute {
  std::string name;
  bool optional = false;
  ExpressType type;
};

struct ExpressEntity {
  std::string name, parent;  // as written; parent in capitals
  bool abstract = false;
  std::vector<ExpressAttribute> attributes;  // its own
  std::set<std::string> derived;             // inherited attributes it derives: written as *
};

class ExpressSchema {
 public:
  /// The text of a .exp file.
  explicit ExpressSchema(const std::string& text);

  const std::map<std::string, ExpressEntity>& entities() const { return entities_; }  // by name in capitals
  bool is_a(std::string entity, const std::string& ancestor) const;
  std::vector<ExpressAttribute> all_attributes(const std::string& entity) const;

  /// What is wrong with one instance: number and types of arguments, required ones, enumeration values, kinds of what
  /// is referred to. Empty if nothing is.
  std::vector<std::string> check(const step::File& file, const step::Instance& instance) const;

 private:
  std::string check_value(const step::File& file, const step::Value& value, const ExpressType& type) const;
  std::string check_named(const step::File& file, const step::Value& value, const std::string& name) const;
  void read_type(const std::string& statement);
  void read_entity(const std::string& block);
  static ExpressType parse_type(std::string text);

  std::map<std::string, ExpressEntity> entities_;
  std::map<std::string, ExpressType> types_;
};

}  // namespace plumbline::test
