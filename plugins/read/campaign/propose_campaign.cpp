#include "propose_campaign.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <functional>
#include <map>
#include <set>

#include "base/text/text.hpp"
#include "photo/images/photograph_header.hpp"
#include "plumbline/folder_files.hpp"
#include "recognise_tables.hpp"
#include "survey/files/survey_format.hpp"
#include "survey/model/repeated_readings.hpp"
#include "unused_files.hpp"
#include "whole_design.hpp"
#include "workbook_tables.hpp"

namespace plumbline::campaign {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

constexpr std::size_t kLargestText = 16 << 20;  // of a table or a calibration [bytes]

std::string text_of(const fs::path& path, std::size_t bytes = kLargestText) {
  std::ifstream stream(path, std::ios::binary);
  std::string text(bytes, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(bytes));
  text.resize(stream.gcount());
  return text;
}

bool ends_as(const std::string& name, std::initializer_list<const char*> endings) {
  const std::string small = text::to_lower(name);
  return std::any_of(endings.begin(), endings.end(), [&](const char* ending) { return small.ends_with(ending); });
}

/// As YAML writes a name: quoted where its characters mean something there.
std::string yaml_text(const std::string& name) {
  static const std::string plain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./- ";
  const bool simple = std::all_of(name.begin(), name.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0x80) || plain.find(c) != std::string::npos;
  });
  if (simple && !name.empty() && name.front() != ' ' && name.front() != '-' && name.back() != ' ') return name;
  std::string text = "\"";
  for (const char c : name) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code == 0x7f)  // a name may hold a line's end, or what moves a terminal's cursor
      text += fmt::format("\\x{:02x}", code);
    else
      text += (c == '"' || c == '\\' ? "\\" : "") + std::string(1, c);
  }
  return text + "\"";
}

std::string listed(const Names& names) {
  if (names.size() == 1) return yaml_text(names.front());
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "[" : ", ") + yaml_text(name);
  return text + "]";
}

std::string few(const Names& names) {
  constexpr std::size_t most = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text += (i ? ", " : "") + names[i];
  return names.size() > most ? text + " and " + std::to_string(names.size() - most) + " more" : text;
}

/// Photographs that one camera took, as far as their headers tell.
struct Group {
  std::string model;  ///< make, model and serial number; empty if EXIF says nothing
  int width = 0, height = 0;
  Names names;
};

struct CameraFile {
  std::string name;
  CameraCalibration calibration;
};

class Sorter {
 public:
  Sorter(const fs::path& root, Names files, const Names& readable) : root_(root) {
    std::sort(files.begin(), files.end());
    for (const std::string& file : files)
      if (std::find(readable.begin(), readable.end(), file) != readable.end())
        survey_.push_back(file);
      else
        sort(file);
    take_out_repeated_files();
  }

  Proposal propose() {
    proposal_.yaml =
        "plumbline_campaign: 1\n# Proposed from what lies in this folder: check each line, then `plumbline campaign "
        "check`.\nname: " +
        yaml_text(fs::weakly_canonical(root_).filename().string()) + "\n";
    add_photographs();
    if (plates_.empty())
      lack("plates", "plates.csv",
           "no table says which tag hangs at which anchor (columns anchor, role, floor, tag_family, tag_id, "
           "tag_size_mm, tag_x_mm, tag_y_mm, tag_z_mm, facing_azimuth_deg)");
    else
      add("plates", one_of("plates", plates_), "which tag hangs at which anchor");
    if (survey_.empty())
      lack("survey", "survey/*.gsi", "no file with readings of a total station was found");
    else
      add("survey", listed(survey_), "readings of the total station");
    if (!repeated_.empty())
      proposal_.yaml += "# not proposed: " + listed(repeated_) + "   # its readings stand in a file of survey, too\n";
    add_control();
    if (designs_.empty())
      lack("design", "design.ifc", "no IFC file was found");
    else
      add("design", one_of("design", designs_), "the design");
    if (!dated_)
      proposal_.yaml +=
          "# date: 2026-05-12   # when it was measured; no file says it, and the as-built model is dated by the design "
          "then\n";
    if (!broken_.empty())
      proposal_.yaml +=
          "# unused: " + listed(broken_) + "   # cannot be read: with this line the rest goes on without\n";
    if (!open_) proposal_.pipeline = other_pipeline();
    if (!proposal_.pipeline.empty())
      proposal_.found.push_back("as it is, the folder is one for: plumbline run " + proposal_.pipeline);
    for (const std::string& name : office_)
      proposal_.wrong.push_back(name +
                                ": this format of spreadsheets is not read; save it as .xlsx, or its sheet as CSV");
    if (plates_.empty() || control_.empty())
      for (const std::string& name : strange_workbooks_)
        proposal_.wrong.push_back(name + ": no sheet of it has the columns of plates or of known points");
    return std::move(proposal_);
  }

 private:
  void sort(const std::string& file) {
    if (is_system_file(file) || file == "campaign.yaml") return;
    const fs::path path = root_ / file;
    if (is_photograph_name(file)) return add_photograph(file);
    if (ends_as(file, {".xls", ".ods", ".numbers"})) return office_.push_back(file);
    if (ends_as(file, {".ifc", ".ifczip", ".ifcxml"})) {
      designs_.push_back(file);
      return attempt([&] { require_whole_design(path, file); });
    }
    std::error_code error;
    if (fs::file_size(path, error) > kLargestText || error) return;
    if (is_workbook(file)) return sort_workbook(file);
    const std::string text = text_of(path);
    if (ends_as(file, {".yaml", ".yml"}) && text.find("plumbline_camera") != std::string::npos) {
      attempt([&] { cameras_.push_back({file, parse_camera(text, file)}); });
    } else if (is_table_of_plates(text)) {
      take_plates(file, [&] { return text; });
    } else if (is_table_of_tags(text)) {
      observations_.push_back(file);
    } else if (holds_readings(path, file)) {
      survey_.push_back(file);
    } else if (ends_as(file, {".csv", ".txt"})) {
      sort_points(file, [&] { return text; });
    }
  }

  void take_plates(const std::string& file, const std::function<std::string()>& text) {
    plates_.push_back(file);
    std::vector<std::string> notes;  // of the owner's own columns: nothing to mend
    attempt([&] { parse_plates(text(), file, CampaignUse::site, &notes); });
  }

  /// One workbook may hold a table of plates and one of known points, each on a sheet of its own.
  void sort_workbook(const std::string& file) {
    bool plates = false, tags = false, points = false;
    try {
      for (const WorkbookSheet& sheet : sheets_of(text_of(root_ / file), file)) {
        if (has_columns_of_sightings(sheet.csv))
          proposal_.wrong.push_back(file + ": sheet '" + sheet.name +
                                    "' holds readings, which are not read from a workbook; save it as CSV");
        else if (is_table_of_plates(sheet.csv))
          plates = true;
        else if (is_table_of_tags(sheet.csv))
          tags = true;
        else
          points = points || (is_called_control(file) || is_called_control(sheet.name)
                                  ? has_columns_of_points(sheet.csv)
                                  : has_columns_of_places(sheet.csv));  // "Nr, Breite, Höhe" is one of panels
      }
    } catch (const std::runtime_error& error) {
      return tell(error.what());
    }
    if (plates) take_plates(file, [&] { return table_text(root_ / file, is_table_of_plates, "a table of plates"); });
    if (tags) observations_.push_back(file);
    if (points || (!plates && !tags && is_called_control(file)))
      sort_points(file, [&] { return control_text(root_ / file); });
    else if (!plates && !tags)
      strange_workbooks_.push_back(file);
  }

  /// What the folder is good for as it is, where that is not a site with photographs of tags.
  std::string other_pipeline() const {
    const bool photographs = !groups_.empty(), surveyed = !(survey_.empty() && control_.empty());
    if (!photographs && !observations_.empty()) return "site_observations";
    if (!photographs && !survey_.empty())
      return plates_.empty() || designs_.empty() ? "survey_campaign" : "site_survey";
    if (photographs && designs_.empty() && surveyed) return "photo_campaign";
    if (photographs && !designs_.empty() && !surveyed) return "site_photographs";
    return "";
  }

  void add_photograph(const std::string& file) {
    Group group;
    try {
      const PhotographHeader header = read_photograph_header(root_ / file);
      group = {header.model + (header.serial.empty() ? "" : " " + header.serial), header.width, header.height, {}};
    } catch (const std::runtime_error& reason) {
      proposal_.wrong.push_back(file + ": " + reason.what());
      return broken_.push_back(file);
    }
    for (Group& known : groups_)
      if (known.model == group.model && known.width == group.width && known.height == group.height)
        return known.names.push_back(file);
    group.names = {file};
    groups_.push_back(std::move(group));
  }

  /// What cannot be read is proposed where its name says what it is, or nothing else is: left out without a word, the
  /// survey's own coordinates would hold the datum.
  void sort_points(const std::string& file, const std::function<std::string()>& text) {
    try {
      if (!parse_control(text(), file).empty()) control_.push_back(file);
    } catch (const std::runtime_error& error) {
      if (!is_workbook(file) && !looks_like_control(text(), file)) return;
      (is_called_control(file) ? control_ : doubtful_control_).push_back(file);
      tell(error.what());
    }
  }

  void add_control() {
    if (control_.empty()) control_.swap(doubtful_control_);
    if (!control_.empty()) return add("control", one_of("control", control_), "known points that carry the datum");
    if (!survey_.empty())
      proposal_.yaml +=
          "# control: control.csv   # no table of known points was found: what the survey files know holds the datum\n";
  }

  /// A job and the table that was exported of it hold the same readings: one of them is proposed, and the pair told.
  void take_out_repeated_files() {
    std::vector<survey::SurveyObservations> surveys;
    std::set<std::string> before, after;
    for (const std::string& file : survey_) {
      std::error_code error;
      if (fs::file_size(root_ / file, error) > kLargestText || error) continue;
      try {
        surveys.push_back(survey::read_survey(text_of(root_ / file), file));
        dated_ = dated_ || !surveys.back().info.date.empty();
      } catch (const std::runtime_error&) {  // of another plugin's reader, or the check tells what is wrong
        continue;
      }
      surveys.back().files = {file};
      before.insert(file);
    }
    if (surveys.size() < 2) return;
    const std::vector<std::string> sentences = survey::take_out_repeated_readings(surveys);
    for (const survey::SurveyObservations& s : surveys) after.insert(s.files.begin(), s.files.end());
    for (const std::string& sentence : sentences) proposal_.wrong.push_back("survey: " + sentence);
    std::erase_if(survey_, [&](const std::string& file) { return before.contains(file) && !after.contains(file); });
    for (const std::string& file : before)
      if (!after.contains(file)) repeated_.push_back(file);
  }

  void attempt(const std::function<void()>& action) {
    try {
      action();
    } catch (const std::runtime_error& error) {
      tell(error.what());
    }
  }
  /// A line each.
  void tell(const std::string& problems) {
    for (const text::Line& line : text::split_lines(problems)) proposal_.wrong.emplace_back(line.text);
  }

  void add(const std::string& key, const std::string& value, const std::string& comment) {
    proposal_.yaml += key + ": " + value + "   # " + comment + "\n";
    proposal_.found.push_back(key + ": " + value);
  }
  void lack(const std::string& key, const std::string& example, const std::string& why) {
    proposal_.yaml += "# " + key + ": " + example + "   # MISSING: " + why + "\n";
    proposal_.wrong.push_back(key + ": " + why);
  }
  /// Of several the one that is called as its key; where none is, all of them stand there, which every run refuses: an
  /// old table of control is no less whole than the new one.
  std::string one_of(const std::string& key, const Names& names) {
    if (names.size() == 1) return yaml_text(names.front());
    const auto called_so = [&](const std::string& name) {
      return text::to_lower(fs::path(name).stem().string()) == key;
    };
    const auto own = std::find_if(names.begin(), names.end(), called_so);
    if (own != names.end() && std::count_if(names.begin(), names.end(), called_so) == 1) {
      proposal_.wrong.push_back(key + ": " + few(names) + " could all be it; " + *own +
                                " is taken. Name the right one");
      return yaml_text(*own);
    }
    open_ = true;
    proposal_.wrong.push_back(key + ": " + few(names) + " could all be it; leave the right one there and no other");
    return listed(names);
  }

  /// Patterns that fit these photographs and no others.
  Names patterns_of(const Names& names) const {
    Names result;
    for (const std::string& pattern : patterns_for(names)) {
      Names members;
      bool alone = true;
      for (const Group& group : groups_)
        for (const std::string& name : group.names) {
          if (!matches_pattern(pattern, name)) continue;
          members.push_back(name);
          alone = alone && std::find(names.begin(), names.end(), name) != names.end();
        }
      if (alone) {
        result.push_back(pattern);
        continue;
      }
      for (const std::string& name : members)
        if (std::find(names.begin(), names.end(), name) != names.end()) result.push_back(name);
    }
    return result;
  }

  void add_photographs() {
    Names all;
    for (const Group& group : groups_) all.insert(all.end(), group.names.begin(), group.names.end());
    std::sort(all.begin(), all.end());
    if (all.empty() && !observations_.empty()) return add_observations();
    if (all.empty()) return lack("images", "images/*.JPG", "no photograph (JPEG, PNG, TIFF) was found");
    proposal_.found.push_back(std::to_string(all.size()) + " photographs of " + std::to_string(groups_.size()) +
                              (groups_.size() == 1 ? " camera" : " cameras"));
    for (const Group& group : groups_)
      proposal_.yaml += "# " + std::to_string(group.names.size()) + " photographs of " +
                        (group.model.empty() ? "a camera that EXIF does not name" : group.model) + ", " +
                        std::to_string(group.width) + " x " + std::to_string(group.height) + "\n";
    if (cameras_.empty()) {
      add("images", listed(patterns_for(all)), "all photographs");
      return lack("camera", "camera.yaml",
                  "no calibration was found; photographs of a board give one: plumbline run calibrate_camera");
    }
    if (groups_.size() == 1 && cameras_.size() == 1) {
      add("images", listed(patterns_for(all)), "all photographs");
      add("camera", yaml_text(cameras_.front().name), "its calibration");
      return check_size(groups_.front(), cameras_.front());
    }
    add_cameras();
  }

  void add_observations() {
    add("observations", one_of("observations", observations_),
        "tags that were measured already, in place of photographs");
    if (cameras_.empty()) return lack("camera", "camera.yaml", "no calibration was found");
    if (cameras_.size() > 1)
      proposal_.wrong.push_back("camera: " + cameras_.front().name +
                                " is taken for all photographs; write which calibration is for which of them");
    add("camera", yaml_text(cameras_.front().name), "its calibration");
  }

  /// Which calibration is for which photographs. A calibration that is nobody's is told: it was made for something.
  void add_cameras() {
    std::vector<Names> taken(cameras_.size());
    std::string missing;
    for (const Group& group : groups_) {
      const std::vector<std::size_t> fits = cameras_of(group);
      if (fits.size() > 1) {
        share_by_folders(group, fits, taken);
      } else if (fits.size() == 1) {
        taken[fits[0]].insert(taken[fits[0]].end(), group.names.begin(), group.names.end());
      } else {
        missing += "  # CALIBRATION.yaml: " + listed(patterns_of(group.names)) + "   # MISSING\n";
        proposal_.wrong.push_back("camera: no calibration of " + std::to_string(group.width) + " x " +
                                  std::to_string(group.height) + " pixels is for " + few(group.names));
      }
    }
    proposal_.yaml += "camera:   # calibration: the photographs it is for\n";
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const std::string& name = cameras_[i].name;
      if (taken[i].empty()) {
        proposal_.wrong.push_back("camera: " + name + " is a calibration for none of the photographs");
        continue;
      }
      const std::string names = listed(patterns_of(taken[i]));
      proposal_.yaml += "  " + yaml_text(name) + ": " + names + "\n";
      proposal_.found.push_back("camera: " + name + " for " + names);
    }
    proposal_.yaml += missing;
  }

  /// Indices of the calibrations of that size; of several, those whose model EXIF names.
  std::vector<std::size_t> cameras_of(const Group& group) const {
    std::vector<std::size_t> fits, named;
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const CameraCalibration& c = cameras_[i].calibration;
      if (c.camera.width != group.width || c.camera.height != group.height) continue;
      fits.push_back(i);
      if (!c.model.empty() && group.model.find(c.model) != std::string::npos) named.push_back(i);
    }
    return named.empty() ? fits : named;
  }

  /// Two bodies of one model: photographs in a folder `crane` are those of `camera_crane.yaml`. Where names do not
  /// tell, somebody must.
  void share_by_folders(const Group& group, const std::vector<std::size_t>& fits, std::vector<Names>& taken) {
    std::map<std::string, Names> folders;
    for (const std::string& name : group.names) folders[fs::path(name).parent_path().string()].push_back(name);
    for (const auto& [folder, names] : folders) {
      std::vector<std::size_t> own;
      for (const std::size_t i : fits)
        if (share_a_word(folder, cameras_[i].name) || share_a_word(folder, cameras_[i].calibration.id))
          own.push_back(i);
      if (own.size() != 1)
        proposal_.wrong.push_back("camera: " + cameras_[fits[0]].name + " and " + cameras_[fits[1]].name +
                                  " both fit " + few(names) +
                                  "; the first is taken. Write which of them took which photographs");
      Names& its = taken[own.size() == 1 ? own[0] : fits[0]];
      its.insert(its.end(), names.begin(), names.end());
    }
  }

  static std::set<std::string> words_of(const std::string& text) {
    constexpr std::size_t shortest = 3;
    std::set<std::string> words;
    std::string word;
    for (const char c : text + " ") {
      const unsigned char u = static_cast<unsigned char>(c);
      if (u < 128 && !std::isalnum(u)) {
        if (word.size() >= shortest) words.insert(word);
        word.clear();
      } else {
        word += static_cast<char>(u < 128 ? std::tolower(u) : u);
      }
    }
    return words;
  }
  static bool share_a_word(const std::string& a, const std::string& b) {
    const std::set<std::string> of_a = words_of(a), of_b = words_of(b);
    return std::any_of(of_a.begin(), of_a.end(), [&](const std::string& word) { return of_b.count(word) > 0; });
  }

  void check_size(const Group& group, const CameraFile& camera) {
    const BrownCamera& calibrated = camera.calibration.camera;
    if (group.width == 0 || (group.width == calibrated.width && group.height == calibrated.height)) return;
    proposal_.wrong.push_back(camera.name + ": was calibrated with " + std::to_string(calibrated.width) + " x " +
                              std::to_string(calibrated.height) + " pixels, the photographs have " +
                              std::to_string(group.width) + " x " + std::to_string(group.height));
  }

  fs::path root_;
  Proposal proposal_;
  std::vector<Group> groups_;
  std::vector<CameraFile> cameras_;
  Names plates_, observations_, survey_, control_, designs_, office_;
  Names strange_workbooks_;  // without a table that a campaign has
  Names doubtful_control_;   // tables of points that cannot be read and may be something else
  Names broken_;             // photographs that cannot be read
  Names repeated_;           // files whose readings another one has
  bool dated_ = false;       // a file of the survey says when it was measured
  bool open_ = false;        // of several files for one key, which it is
};

}  // namespace

Proposal propose_campaign(const fs::path& root, Names files, const Names& readable) {
  return Sorter(root, std::move(files), readable).propose();
}

}  // namespace plumbline::campaign
