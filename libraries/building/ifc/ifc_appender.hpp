// Adds instances to a copy of an IFC file. Every byte that was there stays, in its order; the new lines stand before
// the ENDSEC of the DATA section. What gets a GlobalId gets it from the project's GlobalId and a key, so that writing
// twice gives the same bytes.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "building/ifc/ifc_model.hpp"
#include "building/step/step.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::ifc {

using InstanceId = std::uint64_t;

class Appender {
 public:
  /// `timestamp` [s since 1970] dates the additions; if it is 0 they carry the latest date that the file itself has.
  Appender(const Model& model, std::string project_guid, double length_unit, std::int64_t timestamp);

  InstanceId add(std::string_view keyword, const std::vector<std::string>& arguments);
  /// A subtype of IfcRoot: GlobalId from `key`, the owner history of the additions, name, description, then `rest`.
  /// Throws std::runtime_error if the file already has that GlobalId.
  InstanceId add_root(std::string_view keyword, const std::string& key, const std::string& name,
                      const std::string& description, const std::vector<std::string>& rest);

  /// A length of `metres` in the unit of the file, rounded to a nanometre: the digits beyond are noise.
  std::string length(double metres) const;
  std::string length_measure(double metres) const;  ///< the same as IFCLENGTHMEASURE(…)
  InstanceId add_point(const Eigen::Vector3d& metres);
  InstanceId add_direction(const Eigen::Vector3d& direction);
  /// The position of something under the given placement, in the file's unit, as an IfcLocalPlacement relative to it.
  InstanceId add_placement(InstanceId parent, const Eigen::Vector3d& position_in_parent);
  InstanceId add_placement(InstanceId parent, const RigidTransform& parent_from_own);
  /// An IfcPropertyEnumeration: the file's own, if it has one of that name, since the name must be unique.
  InstanceId enumeration(const std::string& name, const std::vector<const char*>& values);

  Schema schema() const { return model_.schema(); }
  const Model& model() const { return model_; }
  std::size_t count() const { return count_; }  ///< instances added
  /// The lines of all of them, to stand at File::data_end(); nothing can be added afterwards.
  std::string take_lines();

 private:
  InstanceId owner_history();
  InstanceId find_application() const;

  bool is_new(const std::string& guid);

  const Model& model_;
  std::string project_guid_, line_end_, lines_;
  double length_unit_;
  int length_decimals_;
  std::int64_t timestamp_;
  InstanceId next_ = 1, owner_history_ = 0;
  std::size_t count_ = 0;
  std::vector<std::uint64_t> guids_;     // hashes of the file's, ascending
  std::set<std::uint64_t> added_guids_;  // of the additions
};

/// The properties of one set, in order; values that are nan are left out.
class PropertySet {
 public:
  explicit PropertySet(Appender& appender) : appender_(appender) {}

  void length(const std::string& name, double metres, const std::string& description = "");
  /// As IFCPOSITIVELENGTHMEASURE, which some standard property sets ask for; left out unless it is above zero.
  void positive_length(const std::string& name, double metres, const std::string& description = "");
  void real(const std::string& name, double value, const std::string& description = "");
  void probability(const std::string& name, double value, const std::string& description = "");
  void angle(const std::string& name, double radian, double plane_angle_unit, const std::string& description = "");
  void integer(const std::string& name, std::int64_t value, const std::string& description = "");
  void boolean(const std::string& name, bool value, const std::string& description = "");
  void label(const std::string& name, const std::string& value, const std::string& description = "");
  void choice(const std::string& name, const std::string& value, InstanceId enumeration,
              const std::string& description = "");
  void lengths(const std::string& name, const std::vector<double>& metres, const std::string& description = "");
  void reals(const std::string& name, const std::vector<double>& values, const std::string& description = "");
  void labels(const std::string& name, const std::vector<std::string>& values, const std::string& description = "");
  /// An instant as text, ISO 8601.
  void date_time(const std::string& name, const std::string& value, const std::string& description = "");
  /// ±metres, with 0 as set point where the schema has one.
  void plus_minus(const std::string& name, double metres, const std::string& description = "") {
    bounds(name, -metres, metres, description);
  }
  /// From `lower` to `upper` about 0, which lies between them.
  void bounds(const std::string& name, double lower, double upper, const std::string& description = "");
  void table(const std::string& name, const std::vector<std::pair<double, double>>& metres_to_ratio,
             const std::string& description = "");

  bool empty() const { return properties_.empty(); }
  /// Writes the set and its relation to `objects`. The key makes the GlobalIds.
  InstanceId attach(const std::string& key, const std::string& name, const std::string& description,
                    const std::vector<InstanceId>& objects);

 private:
  void single(const std::string& name, const std::string& value, const std::string& description);
  void listed(const std::string& name, const std::vector<std::string>& values, const std::string& description);

  Appender& appender_;
  std::vector<InstanceId> properties_;
};

}  // namespace plumbline::ifc
