// A Vulkan device that runs compute shaders, with the validation layer where it is installed.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <vulkan/vulkan_raii.hpp>

namespace nlg {

class ComputeDevice {
 public:
  // nullopt where there is no device, a software one included
  static std::optional<ComputeDevice> find() {
    ComputeDevice device;
    const char* const layer = "VK_LAYER_KHRONOS_validation";
    std::vector<const char*> layers, extensions;
    for (const vk::LayerProperties& known : device.context_.enumerateInstanceLayerProperties()) {
      if (std::strcmp(known.layerName, layer) == 0)
        layers.push_back(layer), extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    }
    device.is_validated_ = !layers.empty();
    const vk::ApplicationInfo application("nlg tests", 1, nullptr, 0, VK_API_VERSION_1_1);
    device.instance_ = vk::raii::Instance(device.context_, vk::InstanceCreateInfo({}, &application, layers, extensions));
    if (device.is_validated_) {
      using Severity = vk::DebugUtilsMessageSeverityFlagBitsEXT;
      using Type = vk::DebugUtilsMessageTypeFlagBitsEXT;
      device.messenger_ = vk::raii::DebugUtilsMessengerEXT(
          device.instance_,
          vk::DebugUtilsMessengerCreateInfoEXT({}, Severity::eWarning | Severity::eError, Type::eValidation | Type::ePerformance,
                                               &note, device.messages_.get()));
    }
    std::vector<vk::raii::PhysicalDevice> all = vk::raii::PhysicalDevices(device.instance_);
    if (all.empty()) return std::nullopt;
    device.physical_ = std::move(all.front());
    const auto families = device.physical_.getQueueFamilyProperties();
    while (device.family_ < families.size() && !(families[device.family_].queueFlags & vk::QueueFlagBits::eCompute))
      ++device.family_;
    if (device.family_ == families.size()) return std::nullopt;
    const float priority = 1.0f;
    const vk::DeviceQueueCreateInfo queue({}, device.family_, 1, &priority);
    device.device_ = vk::raii::Device(device.physical_, vk::DeviceCreateInfo({}, queue));
    return device;
  }

  std::string name() const { return physical_.getProperties().deviceName; }
  bool isValidated() const { return is_validated_; }
  // what the validation layer has said
  const std::vector<std::string>& messages() const { return *messages_; }

  struct Buffer {
    vk::raii::Buffer buffer = nullptr;
    vk::raii::DeviceMemory memory = nullptr;
    void* mapped = nullptr;
    size_t word_count = 0;

    std::vector<uint32_t> words() const {
      const auto* first = static_cast<const uint32_t*>(mapped);
      return {first, first + word_count};
    }
  };

  // RGBA16F in three dimensions, that shaders write, or read with a linear filter.
  struct Image {
    vk::raii::Image image = nullptr;
    vk::raii::DeviceMemory memory = nullptr;
    vk::raii::ImageView view = nullptr;
    vk::raii::Sampler sampler = nullptr;
    vk::Extent3D size;
  };

  // What a shader has at one of its bindings.
  struct Binding {
    vk::DescriptorType type;
    const Buffer* buffer = nullptr;
    const Image* image = nullptr;

    static Binding storage(const Buffer& buffer) { return {vk::DescriptorType::eStorageBuffer, &buffer}; }
    static Binding uniform(const Buffer& buffer) { return {vk::DescriptorType::eUniformBuffer, &buffer}; }
    static Binding written(const Image& image) { return {vk::DescriptorType::eStorageImage, nullptr, &image}; }
    static Binding sampled(const Image& image) { return {vk::DescriptorType::eCombinedImageSampler, nullptr, &image}; }
  };

  // A compute shader and what it reads and writes.
  struct Pass {
    vk::raii::DescriptorSetLayout set_layout = nullptr;
    vk::raii::PipelineLayout layout = nullptr;
    vk::raii::Pipeline pipeline = nullptr;
    vk::raii::DescriptorPool pool = nullptr;
    vk::raii::DescriptorSet set = nullptr;
  };

  Buffer makeBuffer(size_t words) const {
    constexpr auto kUsage =
        vk::BufferUsageFlagBits::eStorageBuffer | vk::BufferUsageFlagBits::eUniformBuffer | vk::BufferUsageFlagBits::eTransferDst;
    Buffer result;
    result.word_count = words;
    result.buffer = vk::raii::Buffer(device_, vk::BufferCreateInfo({}, words * sizeof(uint32_t), kUsage));
    result.memory = allocate(result.buffer.getMemoryRequirements(),
                             vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent);
    result.buffer.bindMemory(*result.memory, 0);
    result.mapped = result.memory.mapMemory(0, VK_WHOLE_SIZE);
    return result;
  }

  Buffer makeBuffer(const std::vector<uint32_t>& words) const {
    Buffer result = makeBuffer(words.size());
    std::memcpy(result.mapped, words.data(), words.size() * sizeof(uint32_t));
    return result;
  }

  Image makeImage(const std::array<uint32_t, 3>& size) const {
    using Usage = vk::ImageUsageFlagBits;
    constexpr vk::Format kFormat = vk::Format::eR16G16B16A16Sfloat;
    Image result;
    result.size = vk::Extent3D(size[0], size[1], size[2]);
    result.image = vk::raii::Image(
        device_, vk::ImageCreateInfo({}, vk::ImageType::e3D, kFormat, result.size, 1, 1, vk::SampleCountFlagBits::e1,
                                     vk::ImageTiling::eOptimal, Usage::eStorage | Usage::eSampled | Usage::eTransferSrc));
    result.memory = allocate(result.image.getMemoryRequirements(), vk::MemoryPropertyFlagBits::eDeviceLocal);
    result.image.bindMemory(*result.memory, 0);
    result.view = vk::raii::ImageView(
        device_, vk::ImageViewCreateInfo({}, *result.image, vk::ImageViewType::e3D, kFormat, {}, kWholeImage));
    constexpr auto kClamped = vk::SamplerAddressMode::eClampToEdge;
    result.sampler =
        vk::raii::Sampler(device_, vk::SamplerCreateInfo({}, vk::Filter::eLinear, vk::Filter::eLinear,
                                                         vk::SamplerMipmapMode::eNearest, kClamped, kClamped, kClamped));
    submit([&](const vk::raii::CommandBuffer& command) {
      change(command, *result.image, vk::ImageLayout::eUndefined, vk::ImageLayout::eGeneral);
    });
    return result;
  }

  // bindings   0, 1 …; they live longer than the pass
  Pass makePass(const std::string& spirv_path, const std::vector<Binding>& bindings) const {
    Pass pass;
    std::vector<vk::DescriptorSetLayoutBinding> slots;
    std::vector<vk::DescriptorPoolSize> sizes;
    for (const Binding& binding : bindings) {
      slots.push_back({static_cast<uint32_t>(slots.size()), binding.type, 1, vk::ShaderStageFlagBits::eCompute});
      sizes.emplace_back(binding.type, 1);
    }
    pass.set_layout = vk::raii::DescriptorSetLayout(device_, vk::DescriptorSetLayoutCreateInfo({}, slots));
    pass.layout = vk::raii::PipelineLayout(device_, vk::PipelineLayoutCreateInfo({}, *pass.set_layout));
    const std::vector<uint32_t> code = read(spirv_path);
    const vk::raii::ShaderModule shader(device_, vk::ShaderModuleCreateInfo({}, code));
    const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *shader, "main");
    pass.pipeline = vk::raii::Pipeline(device_, nullptr, vk::ComputePipelineCreateInfo({}, stage, *pass.layout));
    pass.pool = vk::raii::DescriptorPool(
        device_, vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 1, sizes));
    pass.set = std::move(vk::raii::DescriptorSets(device_, vk::DescriptorSetAllocateInfo(*pass.pool, *pass.set_layout)).front());
    for (uint32_t b = 0; b < bindings.size(); ++b) {
      const Binding& of = bindings[b];
      vk::DescriptorBufferInfo buffer;
      vk::DescriptorImageInfo image;
      vk::WriteDescriptorSet write(*pass.set, b, 0, 1, of.type);
      if (of.buffer != nullptr) {
        buffer = vk::DescriptorBufferInfo(*of.buffer->buffer, 0, VK_WHOLE_SIZE);
        write.pBufferInfo = &buffer;
      } else {
        image = vk::DescriptorImageInfo(*of.image->sampler, *of.image->view, vk::ImageLayout::eGeneral);
        write.pImageInfo = &image;
      }
      device_.updateDescriptorSets(write, nullptr);
    }
    return pass;
  }

  // Returns when the shader is through and what it has written is seen by the host and by later passes.
  void run(const Pass& pass, const std::array<uint32_t, 3>& groups) const {
    submit([&](const vk::raii::CommandBuffer& command) { record(command, pass, groups); });
  }

  // A shader with storage buffers 0, 1 …; the last one comes back.
  // inputs         buffers in their order but the last
  // output_words   size of the last
  std::vector<uint32_t> run(const std::string& spirv_path, const std::vector<const std::vector<uint32_t>*>& inputs,
                            size_t output_words, uint32_t groups) const {
    std::vector<Buffer> buffers;
    buffers.reserve(inputs.size() + 1);
    for (const std::vector<uint32_t>* input : inputs) buffers.push_back(makeBuffer(*input));
    buffers.push_back(makeBuffer(output_words));
    std::vector<Binding> bindings;
    bindings.reserve(buffers.size());
    for (const Buffer& buffer : buffers) bindings.push_back(Binding::storage(buffer));
    run(makePass(spirv_path, bindings), {groups, 1, 1});
    return buffers.back().words();
  }

  // Pairs of halves, x fastest: two words a texel.
  std::vector<uint32_t> texels(const Image& image) const {
    const Buffer copy = makeBuffer(size_t{2} * image.size.width * image.size.height * image.size.depth);
    submit([&](const vk::raii::CommandBuffer& command) {
      change(command, *image.image, vk::ImageLayout::eGeneral, vk::ImageLayout::eTransferSrcOptimal);
      const vk::BufferImageCopy whole(0, 0, 0, {vk::ImageAspectFlagBits::eColor, 0, 0, 1}, {}, image.size);
      command.copyImageToBuffer(*image.image, vk::ImageLayout::eTransferSrcOptimal, *copy.buffer, whole);
      change(command, *image.image, vk::ImageLayout::eTransferSrcOptimal, vk::ImageLayout::eGeneral);
      const vk::MemoryBarrier visible(vk::AccessFlagBits::eTransferWrite, vk::AccessFlagBits::eHostRead);
      command.pipelineBarrier(vk::PipelineStageFlagBits::eTransfer, vk::PipelineStageFlagBits::eHost, {}, visible, nullptr,
                              nullptr);
    });
    return copy.words();
  }

 private:
  static constexpr vk::ImageSubresourceRange kWholeImage{vk::ImageAspectFlagBits::eColor, 0, 1, 0, 1};

  static VKAPI_ATTR VkBool32 VKAPI_CALL note(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                             const VkDebugUtilsMessengerCallbackDataEXT* message, void* messages) {
    static_cast<std::vector<std::string>*>(messages)->push_back(message->pMessage);
    return VK_FALSE;
  }

  static std::vector<uint32_t> read(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    if (bytes.empty()) throw std::runtime_error(path + ": expected a SPIR-V module");
    std::vector<uint32_t> words(bytes.size() / sizeof(uint32_t));
    std::memcpy(words.data(), bytes.data(), words.size() * sizeof(uint32_t));
    return words;
  }

  // The first type of memory that has what is wanted; the device's own where it can be, for the host's is slow to read from
  // there.
  vk::raii::DeviceMemory allocate(const vk::MemoryRequirements& needed, vk::MemoryPropertyFlags wanted) const {
    const vk::PhysicalDeviceMemoryProperties memory = physical_.getMemoryProperties();
    for (const vk::MemoryPropertyFlags flags : {wanted | vk::MemoryPropertyFlagBits::eDeviceLocal, wanted}) {
      for (uint32_t type = 0; type < memory.memoryTypeCount; ++type) {
        if ((needed.memoryTypeBits >> type & 1) && (memory.memoryTypes[type].propertyFlags & flags) == flags)
          return {device_, vk::MemoryAllocateInfo(needed.size, type)};
      }
    }
    throw std::runtime_error("no memory that is " + vk::to_string(wanted));
  }

  static void record(const vk::raii::CommandBuffer& command, const Pass& pass, const std::array<uint32_t, 3>& groups) {
    command.bindPipeline(vk::PipelineBindPoint::eCompute, *pass.pipeline);
    command.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *pass.layout, 0, *pass.set, nullptr);
    command.dispatch(groups[0], groups[1], groups[2]);
    using Access = vk::AccessFlagBits;
    const vk::MemoryBarrier visible(Access::eShaderWrite, Access::eHostRead | Access::eShaderRead | Access::eTransferRead);
    using Stage = vk::PipelineStageFlagBits;
    command.pipelineBarrier(Stage::eComputeShader, Stage::eHost | Stage::eComputeShader | Stage::eTransfer, {}, visible, nullptr,
                            nullptr);
  }

  // Waits for whatever was done to an image, and changes its layout.
  static void change(const vk::raii::CommandBuffer& command, vk::Image image, vk::ImageLayout from, vk::ImageLayout to) {
    using Access = vk::AccessFlagBits;
    const vk::ImageMemoryBarrier changed(Access::eMemoryWrite, Access::eMemoryRead | Access::eMemoryWrite, from, to,
                                         VK_QUEUE_FAMILY_IGNORED, VK_QUEUE_FAMILY_IGNORED, image, kWholeImage);
    constexpr auto kAll = vk::PipelineStageFlagBits::eAllCommands;
    command.pipelineBarrier(kAll, kAll, {}, nullptr, nullptr, changed);
  }

  // Records commands, runs them and waits.
  template <class Record>
  void submit(const Record& record) const {
    const vk::raii::CommandPool commands(device_, vk::CommandPoolCreateInfo({}, family_));
    const vk::raii::CommandBuffer command = std::move(
        vk::raii::CommandBuffers(device_, vk::CommandBufferAllocateInfo(*commands, vk::CommandBufferLevel::ePrimary, 1)).front());
    command.begin(vk::CommandBufferBeginInfo(vk::CommandBufferUsageFlagBits::eOneTimeSubmit));
    record(command);
    command.end();
    const vk::raii::Fence fence(device_, vk::FenceCreateInfo());
    device_.getQueue(family_, 0).submit(vk::SubmitInfo(nullptr, nullptr, *command), *fence);
    if (device_.waitForFences(*fence, true, 120'000'000'000u) != vk::Result::eSuccess)
      throw std::runtime_error("the shader does not end");
  }

  // destroyed from the last to the first; messages_ outlives all
  std::unique_ptr<std::vector<std::string>> messages_ = std::make_unique<std::vector<std::string>>();
  vk::raii::Context context_;
  vk::raii::Instance instance_ = nullptr;
  vk::raii::DebugUtilsMessengerEXT messenger_ = nullptr;
  vk::raii::PhysicalDevice physical_ = nullptr;
  vk::raii::Device device_ = nullptr;
  uint32_t family_ = 0;
  bool is_validated_ = false;
};

}  // namespace nlg
