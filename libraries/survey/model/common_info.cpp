#include "survey/model/common_info.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace plumbline::survey {

namespace {

std::string as_stated(const std::string& value) {
  constexpr size_t most = 60;
  return value.empty() ? "none" : value.size() > most ? "'" + value.substr(0, most) + "...'" : "'" + value + "'";
}

std::string as_stated(bool value) { return value ? "yes" : "no"; }

std::string as_stated(double value) {
  const std::string text = fmt::format("{:g}", value);
  return std::isnan(value) ? "none" : text;
}

std::string enumerated(const std::vector<std::string>& parts, size_t most) {
  std::string text;
  for (size_t i = 0; i < std::min(most, parts.size()); ++i) text += (i > 0 ? ", " : "") + parts[i];
  return parts.size() > most ? text + " and " + std::to_string(parts.size() - most) + " more" : text;
}

bool has_readings(const SurveyObservations& s) {
  return !s.observations.empty() || !s.coordinates.empty() || !s.vectors.empty() || !s.local_coordinates.empty();
}

class InfoMerger {
 public:
  InfoMerger(const std::vector<SurveyObservations>& surveys, const std::vector<std::string>& names)
      : surveys_(surveys), names_(names) {
    // A list of points says nothing of how readings were made.
    for (size_t i = 0; i < surveys_.size(); ++i)
      if (has_readings(surveys_[i])) asked_.push_back(i);
    for (size_t i = 0; asked_.empty() && i < surveys_.size(); ++i) asked_.push_back(i);
  }

  CommonInfo run() {
    common_.info = surveys_[asked_.front()].info;
    merge_format();
    merge_instruments();
    merge_what_weighs();
    merge_what_describes();
    return std::move(common_);
  }

 private:
  /// Empty if all say the same, else who says what; then `field` is `neutral`.
  template <typename T>
  std::string reset_if_different(T NetworkInfo::*field, const T& neutral) {
    std::vector<std::pair<std::string, std::vector<std::string>>> values;  // what, and in which files
    for (const size_t i : asked_) {
      const std::string value = as_stated(surveys_[i].info.*field);
      auto at = std::find_if(values.begin(), values.end(), [&](const auto& entry) { return entry.first == value; });
      if (at == values.end()) at = values.insert(at, {value, {}});
      at->second.push_back(names_[i]);
    }
    if (values.size() < 2) return "";
    common_.info.*field = neutral;
    std::vector<std::string> parts;
    for (const auto& [value, files] : values) parts.push_back(value + " in " + enumerated(files, 3));
    return enumerated(parts, 8);
  }

  void warn(const std::string& text) { common_.findings.push_back({Finding::Severity::warning, text, {}}); }
  void warn_if(const std::string& differs, const std::string& what, const std::string& follows) {
    if (!differs.empty()) warn(what + " differs: " + differs + ". " + follows);
  }

  void merge_format() {
    const auto other = [&](const SurveyObservations& s) { return s.info.format != common_.info.format; };
    common_.several_formats = std::any_of(surveys_.begin(), surveys_.end(), other);
    if (common_.several_formats) common_.info.format = "several";
  }

  void merge_instruments() {
    const std::string differs = reset_if_different(&NetworkInfo::instrument, std::string());
    common_.several_instruments = !differs.empty();
    warn_if(differs, "the instrument that the files name",
            "The readings of a file have the profile of its own instrument; the common one where there is none of that "
            "name, or none is named");
    for (size_t i = 0; common_.several_instruments && i < surveys_.size(); ++i) {
      const auto& local = surveys_[i].local_coordinates;
      if (std::any_of(local.begin(), local.end(), [](const auto& c) { return !c.covariance.allFinite(); }))
        warn("local coordinates of " + names_[i] +
             " have no covariance and are weighted with the common profile; choose it with profile or profile_file");
    }
  }

  /// What the result depends on.
  void merge_what_weighs() {
    warn_if(reset_if_different(&NetworkInfo::use_a_posteriori_sigma0, false),
            "whether the files ask to scale covariances with the a posteriori sigma0",
            "They are not scaled; say otherwise with scale_with_sigma0");
    warn_if(reset_if_different(&NetworkInfo::refraction_coefficient, kNotGiven),
            "the refraction coefficient of the files", "The parameter refraction_coefficient holds for all readings");
    warn_if(reset_if_different(&NetworkInfo::largest_misclosure, kNotGiven),
            "the largest misclosure [m] with which a reading takes part",
            "No reading is left out for its misclosure with approximate coordinates");
    merge_coordinate_systems();
  }

  /// Most files state none; two that state others are not in one frame.
  void merge_coordinate_systems() {
    std::vector<std::string> stated, where;
    for (size_t i = 0; i < surveys_.size(); ++i) {
      const std::string& system = surveys_[i].info.coordinate_system;
      if (system.empty() || std::find(stated.begin(), stated.end(), system) != stated.end()) continue;
      stated.push_back(system);
      where.push_back(as_stated(system) + " in " + names_[i]);
    }
    common_.info.coordinate_system = stated.size() == 1 ? stated.front() : "";
    if (stated.size() > 1)
      warn("the coordinate system of the files differs: " + enumerated(where, 8) +
           ". None is stated of the network; look whether the coordinates belong together");
  }

  /// What only describes, in one sentence: files of several days differ in most of it.
  void merge_what_describes() {
    std::vector<std::string> differing;
    const auto take = [&](const std::string& what, const std::string& differs) {
      if (!differs.empty()) differing.push_back(what + " (" + differs + ")");
    };
    const std::string none;
    take("the title", reset_if_different(&NetworkInfo::title, none));
    take("the description", reset_if_different(&NetworkInfo::description, none));
    take("the instrument's serial number", reset_if_different(&NetworkInfo::instrument_serial, none));
    take("the operator", reset_if_different(&NetworkInfo::operator_name, none));
    take("the program", reset_if_different(&NetworkInfo::program, none));
    take("the date", reset_if_different(&NetworkInfo::date, none));
    take("the axes of the file", reset_if_different(&NetworkInfo::axes_xy, std::string("en")));
    take("angles counted counter-clockwise", reset_if_different(&NetworkInfo::angles_right_handed, false));
    take("axes and angles of different hands", reset_if_different(&NetworkInfo::axes_inconsistent, false));
    take("angles in degrees", reset_if_different(&NetworkInfo::angles_in_degrees, false));
    take("the a priori sigma0", reset_if_different(&NetworkInfo::a_priori_sigma0, kNotGiven));
    take("the confidence level", reset_if_different(&NetworkInfo::confidence_level, kNotGiven));
    if (!differing.empty())
      common_.findings.push_back(
          {Finding::Severity::note,
           "not the same in all files, and so not stated of the network: " + enumerated(differing, differing.size()),
           {}});
  }

  const std::vector<SurveyObservations>& surveys_;
  const std::vector<std::string>& names_;
  std::vector<size_t> asked_;
  CommonInfo common_;
};

}  // namespace

CommonInfo common_info(const std::vector<SurveyObservations>& surveys, const std::vector<std::string>& names) {
  return InfoMerger(surveys, names).run();
}

}  // namespace plumbline::survey
