#include "source_texts.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>

#include "test_support.hpp"

namespace plumbline::report::test {

namespace {

/// Files without a reader, and the notices of other languages.
const std::set<std::string> kWithoutReader = {"language.cpp", "catalogue.cpp", "page_style.cpp",    "pack_script.cpp",
                                              "workbook.cpp", "markup.cpp",    "building_lines.cpp"};

/// Of the judgement: what it writes into its artifacts for a reader.
const char* const kJudgement[] = {"accuracy",
                                  "anchor_doubts",
                                  "anchor_judgement",
                                  "common_shift",
                                  "group_shifts",
                                  "deviation",
                                  "deviation_surfaces",
                                  "epoch_movements",
                                  "epochs",
                                  "kept_open",
                                  "panels",
                                  "surfaces",
                                  "trust",
                                  "mounting",
                                  "designed_control"};

/// Not for readers: classes of elements, names of files, what is matched, what a user types.
const std::set<std::string> kNotRead = {
    "small halo",
    "small strong",
    "halo mark",
    "halo small",
    "shaft thin",
    "symbol thin ",
    "slider filter",
    "tasks sortable",
    "words todo",
    "sight suspect",
    ") rotate(",
    "not a result",
    "verdict fail",
    "verdict undecided",
    "verdict pass",
    "by hand",
    "which way the anchors face is not confirmed, so nobody can be told to move one to the right",
    "; say it with facade_normal, or in the rules of facades",
    "<!DOCTYPE html>\n",
    "width=device-width, initial-scale=1",
    "Content-Security-Policy",
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'",
    "max-width:1120px;margin:0 auto;padding:0 32px 40px",
    "@media print{@page{@top-left{content:\"",
    "\";font:8pt sans-serif;color:#444}}}",
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/",
    "floor of a facade",
    "px; 0.1 to 1 for lenses that are focused or stabilised between images",
    "block.with.free_interior=[fx, fy, cx, cy, k1, k2, k3, k4, p1, p2, d1, d2]",
    "class=IfcMechanicalFastener: right=0.3mm, up=0.3mm, out=1mm",
    ": contradicts the survey",
    "badge fail",
    "badge pass",
    "mm and its powers",
    "display:inline-block;width:0.9em;height:0.9em;margin:0 0.3em 0 0.8em;background:",
    "accuracy evaluation: ",
    "panel '"};

/// Statements whose texts are errors for whoever runs the program.
bool refuses(const std::string& word) {
  return word == "throw" || word == "check" || word == "refuse" || word == "unpack_symmetric" || word == "context";
}

std::string resolved(const std::string& literal) {
  static const std::map<std::string, std::string> signs = {{"00A0", "\u00A0"}, {"00a0", "\u00A0"}, {"2013", "\u2013"},
                                                           {"2192", "\u2192"}, {"2212", "\u2212"}, {"03b7", "\u03b7"}};
  std::string text;
  for (std::size_t i = 0; i < literal.size(); ++i) {
    if (literal[i] != '\\') {
      text += literal[i];
    } else if (literal[++i] == 'u') {
      const auto sign = signs.find(literal.substr(i + 1, 4));
      text += sign == signs.end() ? "" : sign->second, i += 4;
    } else {
      text += literal[i] == 'n' ? '\n' : literal[i];
    }
  }
  return text;
}

bool is_for_a_reader(const std::string& text) {
  if (kNotRead.contains(text) || text.starts_with("<svg")) return false;
  const bool lower =
      std::any_of(text.begin(), text.end(), [](char c) { return std::islower(static_cast<unsigned char>(c)) != 0; });
  const std::size_t first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
  if (!lower || first == std::string::npos) return false;
  const bool spaced = text.substr(first, last - first).find(' ') != std::string::npos;
  return spaced || std::isupper(static_cast<unsigned char>(text[first])) != 0;
}

}  // namespace

std::vector<std::string> files_with_texts(const std::filesystem::path& root) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(root / "plugins/show/report")) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(".cpp") && !name.ends_with("_node.cpp") && !kWithoutReader.contains(name))
      files.push_back("plugins/show/report/" + name);
  }
  for (const char* name : kJudgement) files.push_back(std::string("libraries/building/judgement/") + name + ".cpp");
  files.push_back("libraries/building/ifc/doubt_words.hpp");
  files.push_back("libraries/artifacts/input_files_text.hpp");
  // What report.words speaks.
  for (const char* name :
       {"libraries/loop/state/next_words.cpp", "libraries/loop/state/plan_artifact.cpp",
        "libraries/loop/fit/plan_settings.cpp", "libraries/loop/gate/gate.cpp", "libraries/loop/gate/assumed_sills.cpp",
        "libraries/loop/estimate/combine_campaigns.cpp", "plugins/build/loop/facade_input.cpp",
        "plugins/build/loop/panel_names.cpp", "plugins/build/loop/panel_waits.cpp",
        "plugins/build/evaluate/image_plan_node.cpp", "plugins/survey/survey/series_words.cpp"})
    files.push_back(name);
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<SourceText> texts_of(const std::filesystem::path& file) {
  const std::string source = plumbline::test::read_file(file);
  std::vector<SourceText> texts;
  bool adjacent = false, refusing = false;
  int line = 1;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const char c = source[i];
    const auto to_line_end = [&] { i = std::min(source.find('\n', i), source.size()) - 1; };
    if (c == '\n') ++line;
    if (std::isspace(static_cast<unsigned char>(c)) != 0) continue;
    if (source.compare(i, 2, "//") == 0 || c == '#') {
      to_line_end();
      continue;
    }
    if (c == '\'') {
      i += source[i + 1] == '\\' ? 3 : 2;
    } else if (c == '"') {
      std::size_t end = i + 1;
      while (source[end] != '"') end += source[end] == '\\' ? 2 : 1;
      const std::string text = resolved(source.substr(i + 1, end - i - 1));
      if (adjacent)
        texts.back().text += text;
      else if (!refusing)
        texts.push_back({text, line});
      adjacent = !refusing, i = end;
      continue;
    } else if (std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_') {
      std::size_t end = i;
      while (end < source.size() && (std::isalnum(static_cast<unsigned char>(source[end])) != 0 || source[end] == '_'))
        ++end;
      refusing = refusing || refuses(source.substr(i, end - i)), i = end - 1;
    } else if (c == ';') {
      refusing = false;
    }
    adjacent = false;
  }
  std::erase_if(texts, [](const SourceText& text) { return !is_for_a_reader(text.text); });
  return texts;
}

std::vector<std::string> words_between_places(const std::string& text) {
  std::vector<std::string> all;
  std::string words;
  const auto take = [&] {
    const char* const around = " \n:;,.()";
    const std::size_t first = words.find_first_not_of(around), last = words.find_last_not_of(around);
    if (std::count_if(words.begin(), words.end(),
                      [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }) > 1)
      all.push_back(words.substr(first, last - first + 1));
    words.clear();
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '{') {
      take(), i = std::min(text.find('}', i), text.size());
    } else if (text.compare(i, 2, "\u00A0") == 0) {
      words += ' ', ++i;
    } else {
      words += text[i];
    }
  }
  take();
  return all;
}

}  // namespace plumbline::report::test
