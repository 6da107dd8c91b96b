// Hostile skies, Radiance's and OpenEXR's: an image of radiances, or one line of what is wrong.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfStdIO.h>

#include <cmath>

#include "scene/image/sky_file.h"
#include "scene/model/scene_light.h"
#include "tests/fuzz/fuzz.h"

namespace nlg::fuzz {
namespace {

constexpr std::string_view kExrMagic("\x76\x2f\x31\x01", 4);

void check(const SkyImage& image) {
  FUZZ_CHECK(image.width >= 1 && image.width <= kMostSkyColumns, std::to_string(image.width));
  FUZZ_CHECK(image.height >= 1 && image.height <= kMostSkyRows, std::to_string(image.height));
  FUZZ_CHECK(image.texels.size() == static_cast<size_t>(image.width) * image.height, std::to_string(image.texels.size()));
  for (const glm::vec3& texel : image.texels) {
    for (int channel = 0; channel < 3; ++channel)
      FUZZ_CHECK(texel[channel] >= 0.0f && std::isfinite(texel[channel]), std::to_string(texel[channel]));
  }
}

std::string exr(Imf::Compression compression) {
  constexpr int kWidth = 8, kHeight = 4;
  Imf::Header header(kWidth, kHeight);
  header.compression() = compression;
  const std::vector<float> values(kWidth * kHeight, 0.5f);
  Imf::FrameBuffer buffer;
  for (const char* channel : {"R", "G", "B"}) {
    header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
    buffer.insert(channel, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(values.data())), sizeof(float),
                                      sizeof(float) * kWidth));
  }
  Imf::StdOSStream stream;
  {
    Imf::OutputFile file(stream, header, 0);
    file.setFrameBuffer(buffer);
    file.writePixels(kHeight);
  }
  return stream.str();
}

}  // namespace

void readOne(std::string_view bytes) {
  static const ScratchFile hdr_file("sky.hdr"), exr_file("sky.exr");
  const ScratchFile& file = bytes.starts_with(kExrMagic) ? exr_file : hdr_file;
  file.write(bytes);
  isTaken([&] {
    SkyImage image = readSkyFile(file.path(), 0.1).image;
    check(image);
    takeSun(&image);
    check(image);
  });
}

Seeds seeds() {
  const std::string head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n";
  std::string plain, packed;
  for (int x = 0; x < 32; ++x) plain += {64, 32, 16, static_cast<char>(130)};
  for (int row = 0; row < 4; ++row) {
    packed += {2, 2, 0, 8};
    for (int channel = 0; channel < 4; ++channel) packed += {static_cast<char>(128 + 6), 64, 2, 32, 16};
  }
  const std::string runs{64, 32, 16, static_cast<char>(130), 1, 1, 1, 7};
  return {{"plain.hdr", head + plain},
          {"packed.hdr", head + packed},
          {"runs.hdr", head + runs + runs + runs + runs},
          {"none.exr", exr(Imf::NO_COMPRESSION)},
          {"zip.exr", exr(Imf::ZIP_COMPRESSION)},
          {"piz.exr", exr(Imf::PIZ_COMPRESSION)},
          {"b44.exr", exr(Imf::B44_COMPRESSION)},
          {"dwaa.exr", exr(Imf::DWAA_COMPRESSION)}};
}

std::string mutated(std::string bytes, size_t max_size, Random& random) {
  return bytes.starts_with("#?") ? mutatedTextOrBlindly(std::move(bytes), max_size, random)
                                 : mutatedBlindly(std::move(bytes), max_size);
}

}  // namespace nlg::fuzz
