// What a delivered file holds, as two runs are compared by it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace plumbline::runtime {

/// JSON by its numbers; text by its lines, each as words and numbers with a decimal point; of a ZIP archive its files,
/// of the sheets of a workbook (.xlsx) their cells by place; anything else by its bytes, as their count and hash.
nlohmann::ordered_json content_of_file(const std::string& name, std::string_view bytes);

}  // namespace plumbline::runtime
