// Points of several files by their names: which stations of one name are one mark, which numbers began again.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "survey/model/station_identity.hpp"
#include "survey/start/merge_surveys.hpp"

namespace plumbline::survey {

class MergedNames {
 public:
  /// Both are kept by reference.
  MergedNames(const std::vector<SurveyObservations>& surveys, const MergeOptions& options);

  const std::vector<std::string>& files() const { return files_; }  ///< a short, unique name of each
  std::string of(size_t file, const std::string& id) const;         ///< what a point of a file is called now
  const std::vector<Finding>& findings() const { return findings_; }

 private:
  void decide_stations();
  void decide_targets();
  void decide_station(const std::string& station, const std::vector<size_t>& files);
  StationEvidence evidence(const std::string& station, size_t a, size_t b) const;
  void find(Finding::Severity severity, const std::string& text, std::vector<std::string> points) {
    findings_.push_back({severity, text, std::move(points)});
  }

  const std::vector<SurveyObservations>& surveys_;
  const MergeOptions& options_;
  std::vector<std::string> files_;
  std::vector<std::map<std::string, std::string>> renamed_;  // by file
  std::vector<Finding> findings_;
};

}  // namespace plumbline::survey
