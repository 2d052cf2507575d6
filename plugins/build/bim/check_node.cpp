#include "check_node.hpp"

#include "building/ifc/check.hpp"
#include "design_file.hpp"

namespace plumbline::ifc {

void CheckIfc::run(Context& context) {
  const std::uint64_t first = design_file ? index_of(*design_file, context)->largest_id() + 1 : 0;
  const auto index = index_of(*file, context);
  const step::File& checked = *index;
  const std::vector<Violation> violations = check_ifc(checked, first);
  std::string text = checked.name() + ": " + std::to_string(checked.instances().size()) + " instances, " +
                     (violations.empty() ? "no rule broken" : std::to_string(violations.size()) + " violations") + "\n";
  for (const Violation& violation : violations)
    text += violation.rule + ": #" + std::to_string(violation.instance) + " " + violation.words + "\n";
  context.metric("violations", static_cast<double>(violations.size()), "1");
  if (!violations.empty()) {
    const std::string first_words =
        violations[0].rule + ": #" + std::to_string(violations[0].instance) + " " + violations[0].words;
    if (*strict)
      throw std::runtime_error(checked.name() + ": " + std::to_string(violations.size()) + " violations; the first, " +
                               first_words);
    context.warn(std::to_string(violations.size()) + " violations; the first, " + first_words);
  }
  FileT to;
  to.name = "check.txt", to.media_type = "text/plain";
  to.content.assign(text.begin(), text.end());
  report.commit(to);
}

}  // namespace plumbline::ifc
