// Grey pictures as JPEG, for pages and previews.
#pragma once

#include <cstdint>
#include <string>

#include "photo/images/grey_image.hpp"

namespace plumbline {

/// The bytes of a JPEG file of `quality` from 1 to 100. The same input gives the same bytes. Throws
/// std::invalid_argument for a picture without pixels or of more than 65500 each way.
std::string grey_jpeg(const GreyImage& image, int quality = 80);

}  // namespace plumbline
