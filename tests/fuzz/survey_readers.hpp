// What the fuzzers of the survey readers run on every input: the reader gives sound observations or a SurveyReadError,
// nothing else; what it gives can be written and read back. A broken promise is an abort, which both libFuzzer and the
// replay test take for a finding.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>

#include "base/text/csv_table.hpp"
#include "survey/files/dynaml.hpp"
#include "survey/files/field_books.hpp"
#include "survey/files/gama.hpp"
#include "survey/files/gsi.hpp"
#include "survey/files/jobxml.hpp"
#include "survey/files/krumm.hpp"
#include "survey/files/landxml.hpp"
#include "survey/files/rw5.hpp"
#include "survey/files/sdr33.hpp"
#include "survey/files/starnet.hpp"
#include "survey/files/survey_csv.hpp"
#include "survey/files/survey_format.hpp"
#include "survey/files/survey_layout.hpp"
#include "survey/files/zeiss.hpp"

namespace plumbline::fuzz {

inline void promise(bool kept, const char* what) {
  if (kept) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

inline void check(const survey::SurveyObservations& s) {
  const int set_ups = static_cast<int>(s.set_ups.size());
  promise(s.skipped.size() <= 1000, "the list of skipped places stays short");
  for (const survey::Observation& o : s.observations) {
    promise(std::isfinite(o.value), "every observation has a finite value");
    promise(o.set_up >= -1 && o.set_up < set_ups, "set-up indices exist");
    promise(o.sigma > 0 || std::isnan(o.sigma), "standard deviations are positive or not given");
    promise(o.face >= 0 && o.face <= 2, "faces are 0, 1 or 2");
    promise(!std::isinf(o.target_height) && !std::isinf(o.instrument_height), "heights are finite or not given");
  }
  for (const survey::Point& p : s.points)
    for (int axis = 0; axis < 3; ++axis)
      promise(!std::isinf(p.coordinates[axis]), "coordinates are finite or not given");
  for (const survey::LocalCoordinate& c : s.local_coordinates)
    promise(c.set_up >= 0 && c.set_up < set_ups && c.position.allFinite(), "local coordinates are whole");
}

/// Writers may refuse (std::runtime_error); what they write has the same observations.
inline void check_writers(const survey::SurveyObservations& s) {
  using Write = std::string (*)(const survey::SurveyObservations&);
  using Read = survey::SurveyObservations (*)(const std::string&);
  const std::pair<Write, Read> formats[] = {
      {[](const survey::SurveyObservations& x) { return survey::write_gsi(x); },
       [](const std::string& t) { return survey::read_gsi(t, "written"); }},
      {[](const survey::SurveyObservations& x) { return survey::write_landxml(x); },
       [](const std::string& t) { return survey::read_landxml(t, "written"); }},
      {[](const survey::SurveyObservations& x) { return survey::write_survey_csv(x); },
       [](const std::string& t) { return survey::read_survey_csv(t, "written"); }},
      {[](const survey::SurveyObservations& x) { return survey::write_gama_xml(x); },
       [](const std::string& t) { return survey::read_gama_xml(t, "written"); }},
      {[](const survey::SurveyObservations& x) { return survey::write_starnet(x); },
       [](const std::string& t) { return survey::read_starnet(t, "written"); }}};
  for (const auto& [write, read] : formats) {
    std::string text;
    try {
      text = write(s);
    } catch (const std::runtime_error&) {
      continue;
    }
    try {
      check(read(text));
    } catch (const survey::SurveyReadError& error) {
      promise(s.observations.empty(), ("written observations can be read: " + std::string(error.what())).c_str());
    }
  }
}

/// One input in 64, whatever its length: writing and reading back takes ten times as long as reading.
inline bool is_written(std::string_view bytes) {
  std::uint32_t hash = 2166136261u;  // FNV-1a
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return (hash ^ (hash >> 16)) % 64 == 0;
}

template <typename Reader>
void run_reader(std::string_view bytes, Reader read) {
  survey::SurveyObservations s;
  try {
    s = read();
  } catch (const survey::SurveyReadError&) {
    return;
  }
  check(s);
  if (is_written(bytes)) check_writers(s);
}

inline void run_layout(std::string_view bytes) {
  try {
    const survey::SiteLayout layout = survey::read_survey_layout(bytes, "f");
    promise(!layout.markers.empty() && !layout.set_ups.empty(), "a layout has markers and set-ups");
    for (const survey::LayoutMarker& m : layout.markers) {
      promise(m.position.allFinite() && !std::isinf(m.facing_azimuth), "markers have finite places");
      promise(m.floor >= 0 && m.floor <= 1000 && m.column >= 0 && m.column <= 1000, "floors and columns are small");
    }
    for (const survey::LayoutSetUp& s : layout.set_ups) promise(s.position.allFinite(), "set-ups have finite places");
  } catch (const survey::SurveyReadError&) {
  }
}

struct Target {
  const char* name;
  void (*run)(std::string_view bytes);
};

inline constexpr Target kTargets[] = {
    {"gsi", [](std::string_view b) { run_reader(b, [&] { return survey::read_gsi(b, "f"); }); }},
    {"survey_csv", [](std::string_view b) { run_reader(b, [&] { return survey::read_survey_csv(b, "f"); }); }},
    {"setup_coordinates",
     [](std::string_view b) { run_reader(b, [&] { return survey::read_setup_coordinates(b, "f"); }); }},
    {"landxml", [](std::string_view b) { run_reader(b, [&] { return survey::read_landxml(b, "f"); }); }},
    {"jobxml", [](std::string_view b) { run_reader(b, [&] { return survey::read_jobxml(b, "f"); }); }},
    {"sdr33", [](std::string_view b) { run_reader(b, [&] { return survey::read_sdr33(b, "f"); }); }},
    {"rw5", [](std::string_view b) { run_reader(b, [&] { return survey::read_rw5(b, "f"); }); }},
    {"gama", [](std::string_view b) { run_reader(b, [&] { return survey::read_gama_xml(b, "f"); }); }},
    {"krumm", [](std::string_view b) { run_reader(b, [&] { return survey::read_krumm(b, "f"); }); }},
    {"zeiss", [](std::string_view b) { run_reader(b, [&] { return survey::read_zeiss(b, "f"); }); }},
    {"nikon", [](std::string_view b) { run_reader(b, [&] { return survey::read_nikon(b, "f"); }); }},
    {"topcon_gts7", [](std::string_view b) { run_reader(b, [&] { return survey::read_topcon_gts7(b, "f"); }); }},
    {"topcon_gts210", [](std::string_view b) { run_reader(b, [&] { return survey::read_topcon_gts210(b, "f"); }); }},
    {"topcon_level", [](std::string_view b) { run_reader(b, [&] { return survey::read_topcon_level(b, "f"); }); }},
    {"geodimeter", [](std::string_view b) { run_reader(b, [&] { return survey::read_geodimeter(b, "f"); }); }},
    {"idx", [](std::string_view b) { run_reader(b, [&] { return survey::read_idx(b, "f"); }); }},
    {"starnet", [](std::string_view b) { run_reader(b, [&] { return survey::read_starnet(b, "f"); }); }},
    {"dynaml", [](std::string_view b) { run_reader(b, [&] { return survey::read_dynaml(b, "f"); }); }},
    {"survey_layout", run_layout},
    {"survey_format", [](std::string_view b) { run_reader(b, [&] { return survey::read_survey(b, "f"); }); }},
};

inline const Target& target(std::string_view name) {
  for (const Target& candidate : kTargets)
    if (candidate.name == name) return candidate;
  std::fprintf(stderr, "no fuzz target %.*s\n", static_cast<int>(name.size()), name.data());
  std::abort();
}

}  // namespace plumbline::fuzz
