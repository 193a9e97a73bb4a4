// Pictures: views of their planes, files, differences.
#include "arrays.h"
#include "call.h"
#include "handles.h"
#include "keywords.h"

#include <volcaustic/error.h>

namespace volcaustic::python {

namespace {

std::string sizeText(const Image& image) { return std::to_string(image.width) + " x " + std::to_string(image.height); }

/// Views outlive nothing but the picture, so the handle that is their base must be the one that was asked.
py::array plane(const py::object& self, const std::string& channel) {
  const auto& handle = self.cast<const ImageHandle&>();
  const int i = handle.image->find(channel);
  if (i < 0) {
    const std::string nearest = nearestOf(channel, handle.image->channels);
    throw py::key_error("no channel is called '" + channel + "'" +
                        (nearest.empty() ? "" : "; the nearest is '" + nearest + "'"));
  }
  return view(handle.image->planes[static_cast<std::size_t>(i)].data(), {handle.image->height, handle.image->width},
              self, handle.writable);
}

Image& writableImage(const ImageHandle& handle) {
  if (!handle.writable) throw py::value_error("the picture belongs to a result and is read-only; make a copy()");
  return const_cast<Image&>(*handle.image);
}

/// A channel that is there is written over, another one added.
void setPlane(const py::object& self, const std::string& channel, py::handle given) {
  Image& image = writableImage(self.cast<const ImageHandle&>());
  const auto numbers = numbersFrom<float>(given, {image.height, image.width}, channel);
  const int i = image.find(channel);
  std::vector<float>& into = i < 0 ? image.add(channel) : image.planes[static_cast<std::size_t>(i)];
  std::memmove(into.data(), numbers.data(), into.size() * sizeof(float));
}

ImageHandle imageOf(int width, int height, const py::dict& planes) {
  constexpr int kMost = 1 << 20;
  if (width < 1 || height < 1 || width > kMost || height > kMost)
    throw Error(ErrorKind::Usage, "Image(): width and height must be from 1 to " + std::to_string(kMost));
  Image image;
  image.width = width;
  image.height = height;
  const py::object made = py::cast(ImageHandle::own(std::move(image)));
  for (const auto& [channel, numbers] : planes) setPlane(made, py::str(channel), numbers);
  return made.cast<ImageHandle>();
}

/// (H, W, N), or (H, W) of a single channel given as a string: one copy.
py::array_t<float> stacked(const ImageHandle& handle, const std::vector<std::string>& channels, const py::object& out) {
  const Image& image = *handle.image;
  std::vector<const float*> planes;
  const py::object self = py::cast(handle);
  for (const std::string& channel : channels) planes.push_back(static_cast<const float*>(plane(self, channel).data()));
  auto result = resultArray<float>(out, {image.height, image.width, static_cast<py::ssize_t>(planes.size())});
  float* pixel = result.mutable_data();
  const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  for (std::size_t p = 0; p < pixels; ++p)
    for (const float* from : planes) *pixel++ = from[p];
  return result;
}

ImageHandle read(const std::filesystem::path& path, const py::kwargs& given) {
  Keywords keywords("read_image()", given);
  Call call(keywords);
  keywords.finish();
  return ImageHandle::own(call.run([&] { return readImage(path, call.context()); }));
}

void write(const std::filesystem::path& path, const ImageHandle& handle, const py::kwargs& given) {
  Keywords keywords("write_image()", given);
  ImageWriteOptions options;
  keywords.into(options);
  Call call(keywords);
  keywords.finish();
  call.run([&, image = handle.image] { writeImage(path, *image, options, call.context()); });
}

struct FlipHandle {
  py::array map;
  double mean = 0, maximum = 0;
  std::vector<double> exposures;
};

FlipHandle flip(const ImageHandle& reference, const ImageHandle& test, const py::kwargs& given) {
  Keywords keywords("flip_difference()", given);
  FlipOptions options;
  keywords.into(options);
  Call call(keywords);
  keywords.finish();
  FlipDifference made =
      call.run([&, a = reference.image, b = test.image] { return flipDifference(*a, *b, options, call.context()); });
  py::array map = adopt<float>(std::move(made.map), {reference.image->height, reference.image->width});
  return {std::move(map), made.mean, made.maximum, std::move(made.exposures)};
}

ImageHandle pictureOfMap(py::handle map) {
  const auto numbers = numbersFrom<float>(map, {-1, -1}, "map");
  if (numbers.size() == 0) throw Error(ErrorKind::Usage, "map: is empty");
  return ImageHandle::own(differencePicture(static_cast<int>(numbers.shape(1)), static_cast<int>(numbers.shape(0)),
                                            {numbers.data(), numbers.data() + numbers.size()}));
}

std::string imageRepr(const ImageHandle& handle) {
  std::string names;
  for (const std::string& channel : handle.image->channels) names += (names.empty() ? "" : " ") + channel;
  return "<volcaustic.Image: " + sizeText(*handle.image) + ", " + names + ">";
}

void addImage(py::module_& m) {
  py::class_<ImageHandle>(m, "Image",
                          "Named planes of 32-bit floats, rows from the top, scene-linear Rec. 709. image[\"R\"] is a "
                          "view of a plane, (height, width).")
      .def(py::init(&imageOf), py::arg("width"), py::arg("height"), py::arg("planes") = py::dict(),
           "planes: {channel: (height, width) numbers}, each copied once.")
      .def_property_readonly("width", [](const ImageHandle& h) { return h.image->width; })
      .def_property_readonly("height", [](const ImageHandle& h) { return h.image->height; })
      .def_property_readonly("shape",
                             [](const ImageHandle& h) { return py::make_tuple(h.image->height, h.image->width); })
      .def_property_readonly("channels", [](const ImageHandle& h) { return py::tuple(py::cast(h.image->channels)); })
      .def_property_readonly(
          "writable", [](const ImageHandle& h) { return h.writable; },
          "False for pictures of results, whose planes are read-only.")
      .def_property(
          "metadata", [](const ImageHandle& h) { return h.image->metadata; },
          [](const ImageHandle& h, std::map<std::string, std::string> metadata) {
            writableImage(h).metadata = std::move(metadata);
          },
          "{name: text}; a copy. Assign another dict to change it.")
      .def("__getitem__", &plane, py::arg("channel"), "(height, width) float32, a view. Raises KeyError.")
      .def("__setitem__", &setPlane, py::arg("channel"), py::arg("numbers"), "Copies into a plane, or adds one.")
      .def("__contains__", [](const ImageHandle& h, const std::string& name) { return h.image->find(name) >= 0; })
      .def("__len__", [](const ImageHandle& h) { return h.image->channels.size(); })
      .def("__iter__", [](const ImageHandle& h) { return py::iter(py::tuple(py::cast(h.image->channels))); })
      .def("stack", &stacked, py::arg("channels") = std::vector<std::string>{"R", "G", "B"}, py::kw_only(),
           py::arg("out") = py::none(), "(height, width, channels) float32: one copy, into `out` where it is given.")
      .def(
          "copy", [](const ImageHandle& h) { return ImageHandle::own(Image(*h.image)); }, "A copy that can be written.")
      .def(
          "__eq__",
          [](const ImageHandle& a, const ImageHandle& b) {
            const Image &i = *a.image, &j = *b.image;
            return &i == &j || (i.width == j.width && i.height == j.height && i.channels == j.channels &&
                                i.planes == j.planes && i.metadata == j.metadata);
          },
          py::is_operator())
      .def("__copy__", [](const ImageHandle& h) { return ImageHandle::own(Image(*h.image)); })
      .def("__deepcopy__", [](const ImageHandle& h, const py::dict&) { return ImageHandle::own(Image(*h.image)); })
      .def("__repr__", &imageRepr);
}

void addDifferences(py::module_& m) {
  py::class_<Difference>(m, "Difference", "Of one channel or grid that both sides have.")
      .def_readonly("name", &Difference::name)
      .def_readonly("mean_absolute", &Difference::meanAbsolute)
      .def_readonly("root_mean_square", &Difference::rootMeanSquare)
      .def_readonly("maximum", &Difference::maximum)
      .def_readonly("mean_of_a", &Difference::meanOfA)
      .def_readonly("mean_of_b", &Difference::meanOfB)
      .def("__repr__", [](const Difference& d) {
        return "<volcaustic.Difference: " + d.name + ", maximum " + std::string(py::repr(py::float_(d.maximum))) + ">";
      });
  py::class_<FlipHandle>(m, "FlipDifference", "How different two pictures look when one flips between them.")
      .def_readonly("map", &FlipHandle::map, "(height, width) float32: 0, no difference is seen, to 1.")
      .def_readonly("mean", &FlipHandle::mean)
      .def_readonly("maximum", &FlipHandle::maximum)
      .def_readonly("exposures", &FlipHandle::exposures, "Stops that the map is the maximum over.");
}

} // namespace

void addImages(py::module_& m) {
  addImage(m);
  addDifferences(m);
  m.def("read_image", &read, py::arg("path"),
        "Any image that OpenImageIO opens, as linear floats. Raises FileError, InputError.");
  m.def("write_image", &write, py::arg("path"), py::arg("image"),
        "Writes by extension: .exr keeps the channels, everything else is a picture for a screen. Keywords: layers, "
        "half, compression, tiles, exposure, tone, bits, alpha, and those of every long call.");
  m.def(
      "compare_images", [](const ImageHandle& a, const ImageHandle& b) { return compareImages(*a.image, *b.image); },
      py::arg("a"), py::arg("b"), py::call_guard<WithoutLock>(),
      "A Difference for each channel. Raises InputError when sizes or channels differ.");
  m.def("flip_difference", &flip, py::arg("reference"), py::arg("test"),
        "FLIP (Andersson et al. 2020, 2021). Keywords: pixels_per_degree, high_dynamic_range, and those of every long "
        "call. Raises InputError when sizes differ or there is no colour.");
  m.def("difference_picture", &pictureOfMap, py::arg("map"), "A map of differences, 0 to 1, in the colours \"magma\".");
}

} // namespace volcaustic::python
