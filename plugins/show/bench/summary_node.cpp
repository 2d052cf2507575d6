// bench.summary: statistics, verdicts and pages of what `plumbline bench` ran.

#include "artifacts/file.hpp"
#include "base/text/whole_file.hpp"
#include "plumbline/node.hpp"
#include "show/bench/figures.hpp"
#include "show/bench/page.hpp"
#include "show/bench/tables.hpp"

namespace {

using namespace plumbline;

struct BenchSummary : Node {
  static constexpr Info info{"bench.summary", "", 3,
                             "Compares alternatives on repeated trials: intervals, verdicts in words, tables, a page"};
  Param<FilePath> cells{"cells", required, "the table of cells that plumbline bench writes (cells.json)"};
  Out<File> html{"html", "page that needs no network"};
  Out<File> csv{"csv", "one line a cell"};
  Out<File> json{"json", "rows, comparisons, failures"};
  Out<File> md{"md", "verdicts and table"};
  Out<File> svg{"svg", "estimates with their intervals by place, a panel a group"};
  Out<File> pdf{"pdf", "the same picture for papers"};
  Out<File> tex{"tex", "macros, so that a paper quotes numbers without copying"};

  void run(Context& context) override {
    const bench::Bench given = bench::parse_bench(text::read_whole(cells->path));
    const bench::Analysis analysis = bench::analyse(given);
    context.metric("cells", static_cast<double>(analysis.cells), "1");
    context.metric("failed", static_cast<double>(analysis.failed), "1");
    // Where nothing is compared nothing is decided.
    context.metric("open", analysis.duels.empty() ? 1 : static_cast<double>(analysis.open), "1");
    for (const std::string& words : analysis.unused)  // the program tells what ran nothing by itself
      if (words.starts_with("measure ") || words.starts_with("all ")) context.warn(words);
    html.commit(file("bench.html", "text/html", to_html(given, analysis)));
    csv.commit(file("bench.csv", "text/csv", to_csv(given)));
    json.commit(file("bench.json", "application/json", to_json(given, analysis)));
    md.commit(file("bench.md", "text/markdown", to_markdown(given, analysis)));
    svg.commit(file("bench.svg", "image/svg+xml", to_svg(figure(given, analysis), bench::Svg::file)));
    pdf.commit(file("bench.pdf", "application/pdf", to_pdf(figure(given, analysis))));
    tex.commit(file("bench.tex", "application/x-tex", to_tex(given, analysis)));
  }

 private:
  static FileT file(const std::string& name, const std::string& media_type, const std::string& text) {
    FileT out;
    out.name = name;
    out.media_type = media_type;
    out.content.assign(text.begin(), text.end());
    return out;
  }
};

}  // namespace

PLUMBLINE_PLUGIN("bench", PLUMBLINE_BUILD_ID, "MIT", BenchSummary)
