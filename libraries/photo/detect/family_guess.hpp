// Which family the tags of a photograph are of where the one that was asked for is not there.
#pragma once

#include <string>
#include <vector>

namespace plumbline {
struct GreyImage;
}

namespace plumbline::detect {

/// "48 tags of DICT_5X5_50" if the photograph, reduced to 2000 px, shows that many tags of a family that is none of
/// `asked`: two at least, four of a family that chance is easily read as. Empty otherwise.
std::string tags_of_another_family(const GreyImage& image, const std::vector<std::string>& asked);

}  // namespace plumbline::detect
