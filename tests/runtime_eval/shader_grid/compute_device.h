// A Vulkan device that runs one compute shader, with the validation layer where it is installed.
#pragma once

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
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

  // Runs a shader with storage buffers 0, 1 …; the last one comes back.
  // inputs         buffers in their order but the last
  // output_words   size of the last
  std::vector<uint32_t> run(const std::string& spirv_path, const std::vector<const std::vector<uint32_t>*>& inputs,
                            size_t output_words, uint32_t groups) const {
    std::vector<Buffer> buffers;
    for (const std::vector<uint32_t>* input : inputs) {
      buffers.push_back(makeBuffer(input->size()));
      std::memcpy(buffers.back().mapped, input->data(), input->size() * sizeof(uint32_t));
    }
    buffers.push_back(makeBuffer(output_words));
    const auto count = static_cast<uint32_t>(buffers.size());

    std::vector<vk::DescriptorSetLayoutBinding> bindings;
    for (uint32_t b = 0; b < count; ++b)
      bindings.push_back({b, vk::DescriptorType::eStorageBuffer, 1, vk::ShaderStageFlagBits::eCompute});
    const vk::raii::DescriptorSetLayout set_layout(device_, vk::DescriptorSetLayoutCreateInfo({}, bindings));
    const vk::raii::PipelineLayout layout(device_, vk::PipelineLayoutCreateInfo({}, *set_layout));
    const std::vector<uint32_t> code = read(spirv_path);
    const vk::raii::ShaderModule shader(device_, vk::ShaderModuleCreateInfo({}, code));
    const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *shader, "main");
    const vk::raii::Pipeline pipeline(device_, nullptr, vk::ComputePipelineCreateInfo({}, stage, *layout));
    const vk::DescriptorPoolSize size(vk::DescriptorType::eStorageBuffer, count);
    const vk::raii::DescriptorPool pool(
        device_, vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 1, size));
    const vk::raii::DescriptorSet set =
        std::move(vk::raii::DescriptorSets(device_, vk::DescriptorSetAllocateInfo(*pool, *set_layout)).front());
    for (uint32_t b = 0; b < count; ++b) {
      const vk::DescriptorBufferInfo info(*buffers[b].buffer, 0, VK_WHOLE_SIZE);
      device_.updateDescriptorSets(vk::WriteDescriptorSet(*set, b, 0, vk::DescriptorType::eStorageBuffer, {}, info), nullptr);
    }
    const vk::raii::CommandPool commands(device_, vk::CommandPoolCreateInfo({}, family_));
    const vk::raii::CommandBuffer command = std::move(
        vk::raii::CommandBuffers(device_, vk::CommandBufferAllocateInfo(*commands, vk::CommandBufferLevel::ePrimary, 1)).front());
    command.begin(vk::CommandBufferBeginInfo(vk::CommandBufferUsageFlagBits::eOneTimeSubmit));
    command.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline);
    command.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout, 0, *set, nullptr);
    command.dispatch(groups, 1, 1);
    const vk::MemoryBarrier visible(vk::AccessFlagBits::eShaderWrite, vk::AccessFlagBits::eHostRead);
    command.pipelineBarrier(vk::PipelineStageFlagBits::eComputeShader, vk::PipelineStageFlagBits::eHost, {}, visible, nullptr,
                            nullptr);
    command.end();
    const vk::raii::Fence fence(device_, vk::FenceCreateInfo());
    device_.getQueue(family_, 0).submit(vk::SubmitInfo(nullptr, nullptr, *command), *fence);
    if (device_.waitForFences(*fence, true, 120'000'000'000u) != vk::Result::eSuccess)
      throw std::runtime_error("the shader does not end");
    const auto* words = static_cast<const uint32_t*>(buffers.back().mapped);
    return {words, words + output_words};
  }

 private:
  struct Buffer {
    vk::raii::Buffer buffer = nullptr;
    vk::raii::DeviceMemory memory = nullptr;
    void* mapped = nullptr;
  };

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

  Buffer makeBuffer(size_t words) const {
    Buffer result;
    result.buffer =
        vk::raii::Buffer(device_, vk::BufferCreateInfo({}, words * sizeof(uint32_t), vk::BufferUsageFlagBits::eStorageBuffer));
    const vk::MemoryRequirements needed = result.buffer.getMemoryRequirements();
    const auto wanted = vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent;
    const vk::PhysicalDeviceMemoryProperties memory = physical_.getMemoryProperties();
    uint32_t type = 0;
    while (type < memory.memoryTypeCount &&
           !((needed.memoryTypeBits >> type & 1) && (memory.memoryTypes[type].propertyFlags & wanted) == wanted))
      ++type;
    if (type == memory.memoryTypeCount) throw std::runtime_error("no memory that the host sees");
    result.memory = vk::raii::DeviceMemory(device_, vk::MemoryAllocateInfo(needed.size, type));
    result.buffer.bindMemory(*result.memory, 0);
    result.mapped = result.memory.mapMemory(0, VK_WHOLE_SIZE);
    return result;
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
