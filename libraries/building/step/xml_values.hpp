// Values of ifcXML as arguments of STEP. Private to libraries/building/step.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::step {

/// The argument that a text is: of a simple kind (s r i b l x e, as XmlSchema has them) or of a list of them, whose
/// items stand one after the other with blanks between; a list of lists is cut where the inner ones all have one
/// length. `resolve` gives what a type comes down to. Nothing where the text is no such value, or has more or fewer
/// items than such lists have. Numbers that are none (NAN, INF) and empty ones are values that are not given, and in a
/// list no value.
std::optional<std::string> argument_of(std::string_view text, std::string_view kind,
                                       const std::function<std::string_view(std::string_view)>& resolve);
/// Of "[3]r"; 0 where lists of that kind have any number of items, or it is no list.
std::size_t size_of_list(std::string_view kind);
/// "a number", "true or false", …
std::string words_of_kind(std::string_view kind);

/// A list of references with others added to it, each once: "$" or "(#1,#2)" and {2, 3} → "(#1,#2,#3)".
std::string with_references(const std::string& list, const std::vector<std::uint64_t>& others);

}  // namespace plumbline::step
