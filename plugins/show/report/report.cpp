#include "show/report/report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <sstream>

#include "artifacts/input_files_text.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/page_style.hpp"
#include "show/report/plot.hpp"
#include "show/report/script_data.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

const AccuracyComparisonT* comparison(const AccuracyT& accuracy, AnchorUse use, AccuracyReference reference) {
  for (const auto& c : accuracy.comparisons)
    if (c->use == use && c->reference == reference) return c.get();
  return nullptr;
}

const AccuracyComparisonT* headline(const AccuracyT& accuracy) {
  const AccuracyComparisonT* check = comparison(accuracy, AnchorUse::check, AccuracyReference::survey);
  if (check && check->anchors > 0) return check;
  return comparison(accuracy, AnchorUse::control, AccuracyReference::survey);
}

std::string anchors_of(const AccuracyComparisonT& c) {
  return c.use == AnchorUse::check ? "check anchors" : "control anchors";
}

void table_row(Markup& html, const std::vector<Cell>& cells) {
  Scope row(html, "tr");
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0)
      html.element("th", {{"scope", "row"}}, cells[i].text);
    else if (cells[i].left)
      html.element("td", {{"class", "text"}}, cells[i].text);
    else if (cells[i].sentence)
      html.element("td", {{"class", "words"}}, cells[i].text);
    else
      html.element("td", cells[i].text);
  }
}

void table_head(Markup& html, const std::vector<Cell>& labels) {
  Scope head(html, "thead");
  Scope row(html, "tr");
  for (const Cell& cell : labels) {
    if (cell.left)
      html.element("th", {{"scope", "col"}, {"class", "text"}}, cell.text);
    else
      html.element("th", {{"scope", "col"}}, cell.text);
  }
}

void folded(Markup& html, const std::string& summary, const std::function<void()>& content, const std::string& paper) {
  Scope details(html, "details", {{"open", "open"}, {"class", paper.empty() ? "fold" : "fold " + paper}});
  html.element("summary", summary);
  content();
}

std::string words_of(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

void verdict_cell(Markup& html, ToleranceVerdict verdict) {
  Scope td(html, "td", {{"class", "text"}});
  if (verdict == ToleranceVerdict::not_measured)
    html.text(unknown);
  else
    verdict_badge(html, verdict);
}

namespace {

void write_files(Markup& html, const std::vector<SourceFile>& files, const std::string& what) {
  if (files.empty()) return;
  folded(html, count(static_cast<long>(files.size()), "file", "files") + " " + what + ", with SHA-256", [&] {
    Scope table(html, "table", {{"class", "facts"}});
    Scope body(html, "tbody");
    for (const SourceFile& file : files) {
      Scope row(html, "tr");
      html.element("th", {{"scope", "row"}}, verbatim(file.path));
      Scope cell(html, "td");
      html.element("code", file.sha256)
          .text(" " + std::to_string(file.size) + "\u00A0bytes" + (file.use.empty() ? "" : ", " + file.use));
    }
  });
}

}  // namespace

void add_nodes(const std::string& pipeline, std::vector<Fact>& facts) {
  std::istringstream lines(pipeline);
  for (std::string line; std::getline(lines, line);)
    if (const std::size_t colon = line.find(": "); colon != std::string::npos)
      facts.emplace_back("Node " + line.substr(0, colon), line.substr(colon + 2));
}

void add_input_files(const InputFilesT& inputs, const InputFilesT& unread, const UsedInputs& used, ReportInput& input) {
  const auto source = [](const InputFileT& file) { return SourceFile{file.path, file.sha256, file.size, file.use}; };
  std::set<std::string> adjusted;
  if (input.block)
    for (const auto& image : input.block->images) adjusted.insert(image->path);
  for (const auto& file : inputs.files) {
    auto& files = file->read ? input.files : input.set_aside;
    files.push_back(source(*file));
    if (input.block && file->read && file->use == "photograph" && !adjusted.contains(file->path))
      files.back().use += ", left out";
  }
  for (const auto& file : unread.files) input.unread.push_back(source(*file));
  if (inputs.files.empty()) return;
  const std::string none = inputs.images == 0 && used.images < 0 ? count(0, "photograph", "photographs") + ", "
                                                                 : "";  // the terminal leaves them out
  input.provenance.emplace_back("Took part", none + what_took_part(inputs, used) + " of the folder");
  if (!used.exclusions.empty()) input.provenance.emplace_back("Left out of the readings", few_names(used.exclusions));
}

void write_provenance(Markup& html, const ReportInput& input) {
  if (input.provenance.empty() && input.files.empty()) return;
  Scope part(html, "section", {{"id", "provenance"}});
  html.element("h2", "Where this comes from");
  html.element("p",
               "Enough to repeat this report bit by bit: the same inputs, versions and seed give the same file. The "
               "record of the run lists every "
               "step with its parameters.");
  {
    Scope table(html, "table", {{"class", "facts"}});
    Scope body(html, "tbody");
    for (const auto& [name, value] : input.provenance) {
      Scope row(html, "tr");
      html.element("th", {{"scope", "row"}}, name);
      html.element("td", value);
    }
  }
  write_files(html, input.files, "that the run read");
  write_files(html, input.set_aside, "set aside by 'unused' in campaign.yaml");
  write_files(html, input.unread,
              input.unread.size() == 1 ? "in the folder that was not read" : "in the folder that were not read");
}

namespace {

void write_navigation(Markup& html, const ReportInput& input) {
  Scope nav(html, "nav", {{"aria-label", "Sections"}});
  const auto link = [&](const char* id, const char* text) {
    html.element("a", {{"href", std::string("#") + id}}, text);
  };
  if (input.deviation) {
    if (input.changes && input.changes->compared) link("changes", "What changed");
    link("view", "In space");
    if (input.photographs && !input.photographs->parts.empty()) link("photographs", "Photographs");
    link("facade", "Facade");
    link("places", input.grid.empty() ? "By floor" : "By floor and axis");
    if (!input.deviation->panels.empty()) link("panels", "Panels");
    link("coverage", "What was judged");
    if (input.deviation->surfaces) link("surfaces", "Surfaces");
  }
  link("quality", "Measuring quality");
  link("numbers", "Key numbers");
  link("floors", "Floors");
  link("passrate", "Pass rate");
  if (!input.deviation) link("facade", "Facade");
  link("transfer", "Height transfer");
  if (input.block) link("block", "Image block");
  if (input.network) link("network", "Survey network");
  link("anchors", "All anchors");
  link("method", "How to read this");
  if (!input.provenance.empty() || !input.files.empty()) link("provenance", "Provenance");
}

void write_body(Markup& html, const ReportInput& input) {
  const bool thousands = input.deviation && many(*input.deviation);
  Scope main(html, "main", {{"class", thousands ? "many" : "few"}});
  {
    Scope header(html, "header");
    html.element("h1", title_spoken(input.title));
    if (!input.subtitle.empty()) html.element("p", {{"class", "subtitle"}}, verbatim(input.subtitle));
    write_installation(html, input);
    if (!input.deviation) write_verdict(html, input);
    write_warnings(html, input);
    write_commands(html, input);
    if (input.control_check) write_control_warning(html, *input.control_check);
    write_navigation(html, input);
  }
  if (input.deviation) {
    if (input.changes) write_changes(html, *input.changes);
    write_view(html, input);
    if (input.photographs) write_photographs(html, *input.photographs);
    write_facade(html, input);
    write_places(html, input);
    write_panels(html, *input.deviation);
    write_coverage(html, *input.deviation);
    if (input.deviation->surfaces) write_surfaces(html, *input.deviation->surfaces);
    Scope part(html, "section", {{"id", "quality"}});
    html.element("h2", "Measuring quality");
    write_verdict(html, input);
  }
  write_key_numbers(html, input.accuracy);
  write_floors(html, input.accuracy);
  write_pass_rates(html, input.accuracy);
  if (!input.deviation) write_facade(html, input);
  write_transfers(html, input.accuracy);
  write_block(html, input);
  if (input.network) write_network(html, *input.network, input.control_check ? &*input.control_check : nullptr);
  write_anchors(html, input);
  write_method(html, input.accuracy);
  write_provenance(html, input);
}

}  // namespace

namespace {

/// The title on every sheet of paper. What would end the string, the rule or the element is written as its code.
std::string running_head(const std::string& title) {
  std::string text;
  for (const char c : title) {
    const auto byte = static_cast<unsigned char>(c);
    const std::string escaped = fmt::format("\\{:02x} ", byte);
    const bool plain = byte >= 0x80 || std::isalnum(byte) != 0 || c == ' ' || c == ',' || c == '.' || c == '-';
    text += plain ? std::string(1, c) : std::string(escaped);
  }
  return "@media print{@page{@top-left{content:\"" + text + "\";font:8pt sans-serif;color:#444}}}";
}

}  // namespace

std::string render_page(const std::string& title, const std::function<void(Markup&)>& write_content) {
  Markup html;
  html.raw("<!DOCTYPE html>\n");
  {
    Scope root(html, "html", {{"lang", speech().language == Language::german ? "de" : "en"}});
    {
      Scope head(html, "head");
      html.empty("meta", {{"charset", "utf-8"}});
      html.empty("meta", {{"name", "viewport"}, {"content", "width=device-width, initial-scale=1"}});
      // Forbids any request, so that the file is what it says: complete.
      html.empty(
          "meta",
          {{"http-equiv", "Content-Security-Policy"},
           {"content", "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"}});
      html.element("title", title);
      html.open("style").raw(page_style).raw(running_head(spoken(title))).close();
    }
    Scope body(html, "body");
    write_content(html);
    if (!speech().plain()) {
      Scope footer(html, "footer", {{"style", "max-width:1120px;margin:0 auto;padding:0 32px 40px"}});
      html.element("p", {{"class", "note"}}, verbatim(limits_of_speech()));
      html.open("script", {{"type", "application/json"}, {"id", "spoken"}}).raw(script_words()).close();
    }
    html.open("script").raw(page_script).raw(verdict_script).raw(space_script).raw(view_script).close();
  }
  return html.str();
}

std::string render_report(const ReportInput& input) {
  const std::string title = title_spoken(input.title) + (input.subtitle.empty() ? "" : ", " + input.subtitle);
  return render_page(title, [&](Markup& html) { write_body(html, input); });
}

}  // namespace plumbline::report
