#include "spoken_pages.hpp"

#include <regex>
#include <utility>

#include "../bim/doubt.hpp"
#include "example.hpp"

namespace plumbline::report::test {

std::vector<std::string> texts_read(std::string html, const std::vector<std::string>& without) {
  for (const std::string& tag : without)
    for (std::size_t at = 0; (at = html.find("<" + tag, at)) != std::string::npos;)
      html.erase(at, html.find("</" + tag + ">", at) - at);
  std::vector<std::string> texts;
  const std::regex read(">([^<]+)<|(?:aria-label|title|placeholder|data-head)=\"([^\"]*)\"");
  for (std::sregex_iterator at(html.begin(), html.end(), read), end; at != end; ++at) {
    std::string text = (*at)[1].matched ? (*at)[1].str() : (*at)[2].str();
    for (const auto& [entity, sign] :
         {std::pair{"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&apos;", "'"}, {"&#39;", "'"}, {"&amp;", "&"}})
      for (std::size_t i = 0; (i = text.find(entity, i)) != std::string::npos; ++i)
        text.replace(i, std::string(entity).size(), sign);
    texts.push_back(text);
  }
  return texts;
}

std::vector<std::string> numbers_of(const std::string& text) {
  static const std::regex fraction(" \\((?:\\d+-)?\\d+(?:/\\d+)?\\)"), number("\\d+(?:\\.\\d+)?");
  const std::string plain = std::regex_replace(text, fraction, "");
  std::vector<std::string> numbers;

  for (std::sregex_iterator at(plain.begin(), plain.end(), number), end; at != end; ++at) numbers.push_back(at->str());
  return numbers;
}

ReportInput full_example() {
  ReportInput input = example();
  input.deviation->misfits.push_back(std::make_unique<MeasurementDoubtT>(plumbline::test::doubt("REASON")));
  input.deviation->misfits.back()->grade = DoubtGrade::misfit, input.deviation->misfits.back()->factor = 1.7;
  input.deviation->requests.push_back(std::make_unique<JudgementRequestT>());
  input.deviation->requests.back()->asked = "class=IfcPlat: vertical=5mm",
  input.deviation->requests.back()->by = "rule";
  input.deviation->requests.back()->not_judged = "it selects no anchor of the plate table";
  input.grid = {{"A", "u", {0, 0, 0}, {1, 0, 0}}, {"1", "v", {2, -5, 0}, {0, 1, 0}}};
  AsBuiltChangesT changes;
  changes.compared = true, changes.before = "2026-05", changes.measured_twice = 3;
  for (const ChangeKind kind :
       {ChangeKind::mended, ChangeKind::opened_again, ChangeKind::unseen, ChangeKind::left_out}) {
    auto change = std::make_unique<AsBuiltChangeT>();
    change->kind = "anchor", change->id = "F01-C01-R1", change->floor = 1, change->before = ToleranceVerdict::fail;
    change->after = ToleranceVerdict::pass, change->change = kind, change->moved = kind == ChangeKind::mended;
    change->movement = {0.004, -0.0012, 0}, change->u = 0.0005;
    changes.changes.push_back(std::move(change));
  }
  input.changes = std::move(changes);
  return input;
}

}  // namespace plumbline::report::test
