// Typed access to the instances of an IFC file: attributes by name, with errors that say which instance, where, and
// what it holds.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "building/ifc/ifc_schema.hpp"
#include "building/step/step.hpp"

namespace plumbline::ifc {

class Model;

/// One instance with its arguments.
class Entity {
 public:
  std::uint64_t id() const { return instance_.id; }
  const std::string& keyword() const;  ///< capitals
  const std::vector<step::Value>& arguments() const { return arguments_; }

  /// The argument of an attribute; an absent trailing argument reads as null. Throws for an attribute our table lacks.
  const step::Value& value(std::string_view attribute) const;
  double number(std::string_view attribute) const;                          ///< typed measures are unwrapped
  std::optional<double> optional_number(std::string_view attribute) const;  ///< nothing for $ and *
  std::string text(std::string_view attribute) const;                       ///< empty for $
  std::uint64_t reference(std::string_view attribute) const;                ///< throws for $
  std::optional<std::uint64_t> optional_reference(std::string_view attribute) const;
  std::vector<std::uint64_t> references(std::string_view attribute) const;  ///< empty for $
  std::vector<double> numbers(std::string_view attribute) const;            ///< empty for $
  [[noreturn]] void fail(std::string_view attribute, const std::string& expected) const;

 private:
  friend class Model;
  const Model* model_ = nullptr;
  step::Instance instance_;
  const EntityLayout* layout_ = nullptr;
  std::vector<step::Value> arguments_;
};

class Model {
 public:
  /// Keeps a reference to `file`. Throws step::Error for a schema we do not read.
  explicit Model(const step::File& file);

  const step::File& file() const { return file_; }
  Schema schema() const { return schema_; }

  /// The instance with this number. Throws step::Error if the file has none, naming `referrer` if that is not zero.
  Entity entity(std::uint64_t id, std::uint64_t referrer = 0) const;
  Entity entity(const step::Instance& instance) const;
  /// Keyword of the instance in capitals; empty if there is none or it is a complex one.
  std::string_view keyword(std::uint64_t id) const;
  /// All instances of a keyword (capitals), in the order of the file.
  std::vector<Entity> all(std::string_view keyword) const;

 private:
  const step::File& file_;
  Schema schema_;
  std::vector<const EntityLayout*> layouts_;  // by step::Instance::type
};

}  // namespace plumbline::ifc
