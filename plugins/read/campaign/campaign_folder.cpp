#include "campaign_folder.hpp"

#include <algorithm>
#include <optional>

#include "base/text/text.hpp"
#include "base/text/whole_file.hpp"
#include "campaign_day.hpp"
#include "campaign_resolver.hpp"
#include "photo/images/photograph_header.hpp"
#include "plumbline/folder_files.hpp"

namespace plumbline::campaign {
namespace {

/// `camera` names one calibration, or of several which photographs each took. Those are added to `images`.
std::vector<CameraOfImages> parse_cameras(const Mapping& mapping, const Resolver& resolver, bool observed,
                                          std::vector<std::string>& images) {
  const YAML::Node node = mapping.get("camera");
  if (!node.IsMap()) return {{resolver.one("camera"), {}}};
  if (mapping.has("images"))
    mapping.fail(node,
                 "'camera' says which photographs each camera took, and 'images' names photographs too; take "
                 "'images' out");
  std::vector<CameraOfImages> cameras;
  for (const auto& entry : node) {
    const std::vector<std::string> files = resolver.files_of("camera", entry.first);
    if (files.size() != 1)
      mapping.fail(entry.first, "'" + entry.first.Scalar() + "' matches " + std::to_string(files.size()) +
                                    " files, expected one calibration");
    for (const CameraOfImages& other : cameras)
      if (other.file == files.front()) mapping.fail(entry.first, "'" + files.front() + "' stands here a second time");
    CameraOfImages camera{files.front(), {}};
    const auto add = [&](const YAML::Node& pattern) {
      if (!pattern.IsScalar())
        mapping.fail(pattern, "'camera': expected photographs of " + camera.file +
                                  ": a file, a pattern such as left/*.jpg, or a list");
      camera.patterns.push_back(pattern.Scalar());
    };
    if (entry.second.IsSequence())
      for (const YAML::Node& item : entry.second) add(item);
    else
      add(entry.second);
    if (camera.patterns.empty()) mapping.fail(entry.second, "'camera': no photographs are named for " + camera.file);
    if (!observed)  // measured tags carry the names of photographs that need not be there
      for (const std::string& image : resolver.files_of("camera", entry.second)) images.push_back(image);
    cameras.push_back(std::move(camera));
  }
  if (cameras.empty()) mapping.fail(node, "'camera' is an empty mapping, expected calibrations");
  std::sort(images.begin(), images.end());
  const auto twice = std::adjacent_find(images.begin(), images.end());
  if (twice != images.end()) mapping.fail(node, "'" + *twice + "' is named for two cameras, and was taken with one");
  return cameras;
}

void take_date(const Mapping& mapping, CampaignDescription& c) {
  const std::string expected = "a day such as 2026-05-12 (year-month-day) or 12.05.2026 (day.month.year)";
  const auto written = mapping.as<std::string>("date", expected.c_str());
  const auto day = day_of(written);
  if (!day) mapping.fail(mapping.get("date"), "'date' is '" + written + "', expected " + expected);
  c.date = day->iso;
  if (day->doubtful)
    c.date_remark = "the date " + written + " of campaign.yaml is read as day.month.year: " + day->iso +
                    "; written like this nobody takes it for another day";
}

}  // namespace

namespace {

/// A campaign.yaml that lacks what a site with photographs has may be whole for something else.
void name_other_use(const Mapping& mapping, Problems& problems) {
  const auto lacks = [&](std::initializer_list<const char*> keys) {
    return std::any_of(keys.begin(), keys.end(), [&](const char* key) { return !mapping.has(key); });
  };
  const bool photographs = mapping.has("images") || mapping.has("observations") || mapping.has("camera");
  std::string pipeline;
  if (!photographs && mapping.has("survey"))
    pipeline = lacks({"plates", "design"}) ? "survey_campaign" : "site_survey";
  else if (mapping.has("images") && lacks({"camera", "plates", "design"}) &&
           (mapping.has("survey") || mapping.has("control")))
    pipeline = "photo_campaign";
  else if (mapping.has("images") && !lacks({"camera", "plates", "design"}) && !mapping.has("survey") &&
           !mapping.has("control"))
    pipeline = "site_photographs";
  if (!pipeline.empty())
    problems.add(CampaignError(mapping.shown(), 0,
                               "where that is not to be had, the folder is one for: plumbline run " + pipeline));
}

}  // namespace

bool Problems::attempt(const std::function<void()>& action) {
  try {
    action();
    return true;
  } catch (const ToldAlready&) {
  } catch (const std::runtime_error& error) {
    lines_.push_back(error.what());
  }
  return false;
}

void Problems::raise() const {
  constexpr std::size_t most = 25;
  if (lines_.empty()) return;
  std::string text;
  for (std::size_t i = 0; i < std::min(lines_.size(), most); ++i) text += (i ? "\n" : "") + lines_[i];
  if (lines_.size() > most) text += "\nand " + std::to_string(lines_.size() - most) + " more of the kind";
  throw CampaignError(text);
}

CampaignDescription parse_campaign(const std::string& yaml, const std::filesystem::path& shown,
                                   std::vector<std::string> files, CampaignUse use) {
  Problems problems;
  CampaignDescription description = parse_campaign(yaml, shown, std::move(files), use, problems);
  problems.raise();
  return description;
}

CampaignDescription parse_campaign(const std::string& yaml, const std::filesystem::path& shown,
                                   std::vector<std::string> files, CampaignUse use, Problems& problems) {
  CampaignDescription c;
  c.control_left_out = false;
  std::optional<Mapping> found;
  if (!problems.attempt([&] {
        found.emplace(load_yaml(yaml, shown), shown,
                      std::vector<std::string>{"plumbline_campaign", "name", "images", "observations", "camera",
                                               "plates", "survey", "instrument", "date", "control", "design", "mapping",
                                               "tolerances", "unused"},
                      &problems);
        found->require_version("plumbline_campaign");
      }))
    return c;
  const Mapping& mapping = *found;
  const bool keys_known = problems.empty();
  c.control_left_out = keys_known && !mapping.has("control");
  Resolver resolver(mapping, std::move(files));
  const bool optional = use == CampaignUse::photographs;
  const auto take = [&](const std::function<void()>& action) { problems.attempt(action); };
  const auto one = [&](const char* key, std::string& file) { take([&] { file = resolver.one(key); }); };
  const auto wanted = [&](const char* key) { return !optional || mapping.has(key); };
  if (use == CampaignUse::alone && (mapping.has("survey") || mapping.has("control")))
    problems.add(CampaignError(shown, 0,
                               "names a survey or control points, which this pipeline of photographs alone does not "
                               "use; with them: plumbline run site_campaign folder=FOLDER"));
  take([&] { c.unused = resolver.set_aside(c.remarks); });
  if (mapping.has("name")) take([&] { c.name = mapping.as<std::string>("name", "a text"); });
  if (mapping.has("instrument"))
    take([&] { c.instrument = mapping.as<std::string>("instrument", "the name of a profile"); });
  if (mapping.has("date")) take([&] { take_date(mapping, c); });
  if (wanted("survey") && use != CampaignUse::alone)
    take([&] {
      if (!mapping.has("survey") && mapping.has("control"))
        throw CampaignError(shown, 0,
                            "the key 'survey' is missing; a list of coordinates that somebody measured is a survey, "
                            "too: write `survey:` for `control:` in front of it");
      c.survey = resolver.many("survey"), c.survey_in_order = resolver.in_order("survey");
    });
  if (mapping.has("control")) one("control", c.control);
  if (use == CampaignUse::survey) return c;
  if (use == CampaignUse::measured) {
    one("plates", c.plates), one("design", c.design);
    if (mapping.has("mapping")) one("mapping", c.mapping);
    if (mapping.has("tolerances")) one("tolerances", c.tolerances);
    return c;
  }
  if (!mapping.has("survey") && !mapping.has("control") && optional)
    problems.add(CampaignError(shown, 0, "found neither 'survey' nor 'control': where the points are, nothing says"));
  if (mapping.has("observations")) one("observations", c.observations);
  const bool observed = mapping.has("observations"), by_camera = mapping.has("camera") && mapping.get("camera").IsMap();
  if (!by_camera && (!observed || mapping.has("images"))) take([&] { c.images = resolver.many("images"); });
  if (wanted("camera")) take([&] { c.cameras = parse_cameras(mapping, resolver, observed, c.images); });
  if (optional && c.cameras.size() > 1)
    take([&] {
      mapping.fail(mapping.get("camera"),
                   "several cameras are one camera.yaml here, each under the name of the folder of its photographs, or "
                   "none: photographs of a folder each calibrate themselves");
    });
  if (wanted("plates")) one("plates", c.plates);
  if (optional) return c;
  one("design", c.design);
  if (mapping.has("mapping")) one("mapping", c.mapping);
  if (mapping.has("tolerances")) one("tolerances", c.tolerances);
  if (keys_known && use == CampaignUse::site) name_other_use(mapping, problems);
  return c;
}

CampaignDescription find_campaign(const std::filesystem::path& folder, std::vector<std::string> files) {
  std::sort(files.begin(), files.end());
  CampaignDescription c;
  for (const std::string& file : files) {
    if (file == "camera.yaml") c.cameras = {{file, {}}};
    if (file == "plates.csv") c.plates = file;
    if (file == "control.csv") c.control = file;
    if (file.starts_with("survey/") && !is_system_file(file)) c.survey.push_back(file);
    if (is_photograph_name(file) && !is_system_file(file)) c.images.push_back(file);
  }
  const std::string mend = "; expected them by these names, or a campaign.yaml that says otherwise";
  if (c.images.empty()) throw CampaignError(folder, 0, "found no photograph (JPEG, PNG or TIFF) in this folder" + mend);
  if (c.survey.empty() && c.control.empty())
    throw CampaignError(folder, 0, "found no survey files in survey/ and no control.csv" + mend);
  return c;
}

void refuse_misnamed_campaign(const std::filesystem::path& folder, const std::vector<std::string>& files) {
  constexpr std::uintmax_t largest = 1 << 20;
  if (std::find(files.begin(), files.end(), "campaign.yaml") != files.end()) return;
  for (const std::string& file : files) {
    const std::filesystem::path path = folder / file;
    const std::string ending = text::to_lower(path.extension().string());
    std::error_code error;
    if (file.find('/') != std::string::npos || (ending != ".yaml" && ending != ".yml" && ending != ".txt") ||
        std::filesystem::file_size(path, error) > largest || error)
      continue;
    if (("\n" + text::read_whole(path)).find("\nplumbline_campaign:") != std::string::npos)
      throw CampaignError(
          folder, 0, "'" + file + "' describes the folder under a name that nothing reads: rename it to campaign.yaml");
  }
}

}  // namespace plumbline::campaign
