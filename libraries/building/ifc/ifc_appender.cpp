#include "building/ifc/ifc_appender.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "building/ifc/ifc_guid.hpp"
#include "building/step/step_writer.hpp"

namespace plumbline::ifc {
namespace {

using step::list;
using step::null;
using step::reference;

constexpr const char* kApplication = "plumbline-as-built";

std::string text_or_null(const std::string& text) { return text.empty() ? null : step::text(text); }

std::vector<std::string> references(const std::vector<InstanceId>& ids) {
  std::vector<std::string> out;
  for (const InstanceId id : ids) out.push_back(reference(id));
  return out;
}

std::uint64_t hash_of(std::string_view guid) {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a; of 10^6 GlobalIds two meet with a chance of 10^-8
  for (const char c : guid) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return hash;
}

/// Every GlobalId of the file: the first argument of whatever starts with a string that looks like one.
std::vector<std::uint64_t> guids_of(const Model& model) {
  const step::File& file = model.file();
  std::vector<bool> without;  // by type: known to begin with something else
  for (const std::string& keyword : file.type_names()) {
    const EntityLayout* layout = find_layout(model.schema(), keyword);
    without.push_back(layout && !layout->attributes.starts_with("GlobalId "));
  }
  std::vector<std::uint64_t> guids;
  const std::string_view bytes = file.bytes();
  const step::Instances instances = file.instances();
  for (std::size_t i = 0; i < instances.size(); ++i) {
    if (without[instances.type(i)]) continue;
    std::size_t at = instances[i].begin;
    while (at < bytes.size() && bytes[at] != '(') ++at;
    for (++at; at < bytes.size() && bytes[at] == ' ';) ++at;
    if (at + 23 < bytes.size() && bytes[at] == '\'' && bytes[at + 23] == '\'')
      guids.push_back(hash_of(bytes.substr(at + 1, 22)));
  }
  std::sort(guids.begin(), guids.end());
  return guids;
}

/// Seconds since 1970 of an IfcTimeStamp; 0 if it is beyond the year 9999, in which nobody has built.
std::int64_t seconds_of(const std::optional<double>& stamp) {
  constexpr double end_of_calendar = 253402300800;
  return stamp && *stamp > 0 && *stamp < end_of_calendar ? static_cast<std::int64_t>(*stamp) : 0;
}

}  // namespace

Appender::Appender(const Model& model, std::string project_guid, double length_unit, std::int64_t timestamp)
    : model_(model),
      project_guid_(std::move(project_guid)),
      length_unit_(length_unit),
      length_decimals_(std::clamp(static_cast<int>(std::ceil(9 + std::log10(length_unit) - 1e-9)), 0, 15)),
      timestamp_(timestamp),
      next_(model.file().free_id()),
      guids_(guids_of(model)) {
  const std::string_view bytes = model.file().bytes();
  const std::size_t first = bytes.find('\n');
  line_end_ = first != std::string::npos && first > 0 && bytes[first - 1] == '\r' ? "\r\n" : "\n";
  if (timestamp_ == 0)
    for (const Entity& history : model.all("IFCOWNERHISTORY"))
      timestamp_ = std::max({timestamp_, seconds_of(history.optional_number("CreationDate")),
                             seconds_of(history.optional_number("LastModifiedDate"))});
}

InstanceId Appender::add(std::string_view keyword, const std::vector<std::string>& arguments) {
  if (next_ == 0)
    throw std::runtime_error(model_.file().name() + ": its largest instance number leaves none for additions");
  lines_ += step::instance(next_, keyword, arguments) + line_end_;
  ++count_;
  return next_++;
}

bool Appender::is_new(const std::string& guid) {
  const std::uint64_t hash = hash_of(guid);
  return !std::binary_search(guids_.begin(), guids_.end(), hash) && added_guids_.insert(hash).second;
}

InstanceId Appender::add_root(std::string_view keyword, const std::string& key, const std::string& name,
                              const std::string& description, const std::vector<std::string>& rest) {
  const std::string guid = derived_ifc_guid(project_guid_, std::string(keyword) + "/" + key);
  if (added_guids_.contains(hash_of(guid)))  // keys of elements begin with their GlobalId
    throw std::runtime_error(model_.file().name() + ": two elements have one GlobalId (" +
                             key.substr(0, key.find('/')) +
                             "), so that what is written of one is that of the other; export the design with unique "
                             "GlobalIds");
  if (!is_new(guid))
    throw std::runtime_error(model_.file().name() + " already holds the as-built " + std::string(keyword) + " '" +
                             name + "' of this epoch (GlobalId " + guid +
                             "); start from the design file, or give another 'epoch'");
  std::vector<std::string> arguments{step::text(guid), reference(owner_history()), text_or_null(name),
                                     text_or_null(description)};
  arguments.insert(arguments.end(), rest.begin(), rest.end());
  return add(keyword, arguments);
}

/// Applications are unique by their identifier, so an earlier epoch's is used again.
InstanceId Appender::find_application() const {
  for (const Entity& application : model_.all("IFCAPPLICATION"))
    if (application.text("ApplicationIdentifier") == kApplication) return application.id();
  return 0;
}

InstanceId Appender::owner_history() {
  if (owner_history_) return owner_history_;
  const InstanceId organization = add("IFCORGANIZATION", {null, step::text("Plumbline"), null, null, null});
  const InstanceId person = add("IFCPERSON", {null, step::text("Plumbline"), null, null, null, null, null, null});
  const InstanceId user = add("IFCPERSONANDORGANIZATION", {reference(person), reference(organization), null});
  InstanceId application = find_application();
  if (!application)
    application = add("IFCAPPLICATION", {reference(organization), step::text("1"),
                                         step::text("Plumbline as-built writer"), step::text(kApplication)});
  // IFC4 wants a modification date with every action other than none.
  const std::string date = step::integer(timestamp_);
  owner_history_ = add("IFCOWNERHISTORY", {reference(user), reference(application), null, step::enumeration("ADDED"),
                                           date, reference(user), reference(application), date});
  return owner_history_;
}

std::string Appender::length(double metres) const {
  return step::real_rounded(metres / length_unit_, length_decimals_);
}
std::string Appender::length_measure(double metres) const { return step::typed("IFCLENGTHMEASURE", length(metres)); }

InstanceId Appender::add_point(const Eigen::Vector3d& metres) {
  return add("IFCCARTESIANPOINT", {list({length(metres.x()), length(metres.y()), length(metres.z())})});
}

InstanceId Appender::add_direction(const Eigen::Vector3d& d) {
  return add("IFCDIRECTION",
             {list({step::real_rounded(d.x(), 12), step::real_rounded(d.y(), 12), step::real_rounded(d.z(), 12)})});
}

InstanceId Appender::add_placement(InstanceId parent, const Eigen::Vector3d& position_in_parent) {
  const InstanceId axes = add("IFCAXIS2PLACEMENT3D", {reference(add_point(position_in_parent)), null, null});
  return add("IFCLOCALPLACEMENT", {parent ? reference(parent) : null, reference(axes)});
}

InstanceId Appender::add_placement(InstanceId parent, const RigidTransform& parent_from_own) {
  const Eigen::Matrix3d axes = parent_from_own.rotation.toRotationMatrix();
  const InstanceId placement =
      add("IFCAXIS2PLACEMENT3D", {reference(add_point(parent_from_own.translation)),
                                  reference(add_direction(axes.col(2))), reference(add_direction(axes.col(0)))});
  return add("IFCLOCALPLACEMENT", {parent ? reference(parent) : null, reference(placement)});
}

InstanceId Appender::enumeration(const std::string& name, const std::vector<const char*>& values) {
  for (const Entity& known : model_.all("IFCPROPERTYENUMERATION"))
    if (known.text("Name") == name) return known.id();
  std::vector<std::string> labels;
  for (const char* value : values) labels.push_back(step::typed("IFCLABEL", step::text(value)));
  return add("IFCPROPERTYENUMERATION", {step::text(name), list(labels), null});
}

std::string Appender::take_lines() {
  const std::string_view original = model_.file().bytes();
  const std::size_t end = model_.file().data_end();
  const bool at_line_start = end == 0 || original[end - 1] == '\n' || original[end - 1] == '\r';
  if (!at_line_start && !lines_.empty()) lines_.insert(0, line_end_);
  return std::move(lines_);
}

void PropertySet::single(const std::string& name, const std::string& value, const std::string& description) {
  properties_.push_back(
      appender_.add("IFCPROPERTYSINGLEVALUE", {step::text(name), text_or_null(description), value, null}));
}

void PropertySet::listed(const std::string& name, const std::vector<std::string>& values,
                         const std::string& description) {
  if (!values.empty())
    properties_.push_back(
        appender_.add("IFCPROPERTYLISTVALUE", {step::text(name), text_or_null(description), list(values), null}));
}

void PropertySet::length(const std::string& name, double metres, const std::string& description) {
  if (std::isfinite(metres)) single(name, appender_.length_measure(metres), description);
}

void PropertySet::positive_length(const std::string& name, double metres, const std::string& description) {
  if (std::isfinite(metres) && appender_.length(metres) != appender_.length(0) && metres > 0)
    single(name, step::typed("IFCPOSITIVELENGTHMEASURE", appender_.length(metres)), description);
}

void PropertySet::real(const std::string& name, double value, const std::string& description) {
  if (std::isfinite(value)) single(name, step::typed("IFCREAL", step::real_rounded(value, 9)), description);
}

void PropertySet::probability(const std::string& name, double value, const std::string& description) {
  if (std::isfinite(value))
    single(name, step::typed("IFCNORMALISEDRATIOMEASURE", step::real_rounded(std::clamp(value, 0.0, 1.0), 6)),
           description);
}

void PropertySet::angle(const std::string& name, double radian, double plane_angle_unit,
                        const std::string& description) {
  if (std::isfinite(radian))
    single(name, step::typed("IFCPLANEANGLEMEASURE", step::real_rounded(radian / plane_angle_unit, 9)), description);
}

/// A label holds 255 characters; what is longer is a text.
static bool is_label(const std::string& text) { return text.size() <= 255; }

void PropertySet::integer(const std::string& name, std::int64_t value, const std::string& description) {
  single(name, step::typed("IFCINTEGER", step::integer(value)), description);
}

void PropertySet::boolean(const std::string& name, bool value, const std::string& description) {
  single(name, step::typed("IFCBOOLEAN", step::boolean(value)), description);
}

void PropertySet::label(const std::string& name, const std::string& value, const std::string& description) {
  if (!value.empty())
    single(name, step::typed(is_label(value) ? "IFCLABEL" : "IFCTEXT", step::text(value)), description);
}

void PropertySet::date_time(const std::string& name, const std::string& value, const std::string& description) {
  // IfcDateTime exists since IFC4.
  if (!value.empty())
    single(name, step::typed(appender_.schema() == Schema::ifc2x3 ? "IFCLABEL" : "IFCDATETIME", step::text(value)),
           description);
}

void PropertySet::choice(const std::string& name, const std::string& value, InstanceId enumeration,
                         const std::string& description) {
  properties_.push_back(appender_.add("IFCPROPERTYENUMERATEDVALUE",
                                      {step::text(name), text_or_null(description),
                                       list({step::typed("IFCLABEL", step::text(value))}), reference(enumeration)}));
}

void PropertySet::lengths(const std::string& name, const std::vector<double>& metres, const std::string& description) {
  std::vector<std::string> values;
  for (const double value : metres) {
    if (!std::isfinite(value)) return;
    values.push_back(appender_.length_measure(value));
  }
  listed(name, values, description);
}

void PropertySet::reals(const std::string& name, const std::vector<double>& numbers, const std::string& description) {
  std::vector<std::string> values;
  for (const double value : numbers) {
    if (!std::isfinite(value)) return;
    values.push_back(step::typed("IFCREAL", step::real_rounded(value, 9)));
  }
  listed(name, values, description);
}

void PropertySet::labels(const std::string& name, const std::vector<std::string>& texts,
                         const std::string& description) {
  // Values of one list are of one type (WR31 of IfcPropertyListValue).
  const bool are_short = std::all_of(texts.begin(), texts.end(), is_label);
  std::vector<std::string> values;
  for (const std::string& value : texts)
    values.push_back(step::typed(are_short ? "IFCLABEL" : "IFCTEXT", step::text(value)));
  listed(name, values, description);
}

void PropertySet::bounds(const std::string& name, double lower, double upper, const std::string& description) {
  std::vector<std::string> arguments{step::text(name), text_or_null(description), appender_.length_measure(upper),
                                     appender_.length_measure(lower), null};
  if (appender_.schema() != Schema::ifc2x3) arguments.push_back(appender_.length_measure(0));
  properties_.push_back(appender_.add("IFCPROPERTYBOUNDEDVALUE", arguments));
}

void PropertySet::table(const std::string& name, const std::vector<std::pair<double, double>>& metres_to_ratio,
                        const std::string& description) {
  if (metres_to_ratio.empty()) return;
  std::vector<std::string> defining, defined;
  for (const auto& [metres, ratio] : metres_to_ratio) {
    defining.push_back(appender_.length_measure(metres));
    defined.push_back(step::typed("IFCNORMALISEDRATIOMEASURE", step::real_rounded(ratio, 6)));
  }
  std::vector<std::string> arguments{
      step::text(name), text_or_null(description), list(defining), list(defined), null, null, null};
  if (appender_.schema() != Schema::ifc2x3) arguments.push_back(null);  // CurveInterpolation
  properties_.push_back(appender_.add("IFCPROPERTYTABLEVALUE", arguments));
}

InstanceId PropertySet::attach(const std::string& key, const std::string& name, const std::string& description,
                               const std::vector<InstanceId>& objects) {
  const InstanceId set =
      appender_.add_root("IFCPROPERTYSET", key + "/" + name, name, description, {list(references(properties_))});
  appender_.add_root("IFCRELDEFINESBYPROPERTIES", key + "/" + name, "", "",
                     {list(references(objects)), reference(set)});
  return set;
}

}  // namespace plumbline::ifc
