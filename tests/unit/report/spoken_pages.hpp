// What tests of languages and units read off a page.
#pragma once

#include <string>
#include <vector>

#include "show/report/report.hpp"

namespace plumbline::report::test {

/// What a reader sees or hears of a page, but for elements with these tags.
std::vector<std::string> texts_read(std::string html, const std::vector<std::string>& without = {"script", "style"});

/// Numbers of a text; a fraction in brackets says one again and does not count.
std::vector<std::string> numbers_of(const std::string& text);

/// The example with what a page may have beside: a misfit, what was not judged, a grid, changes.
ReportInput full_example();

}  // namespace plumbline::report::test
