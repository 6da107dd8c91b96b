"""Neural light grids: light at positions (LightGrid), and theta of weighting functions (Generator). Over the library's interface in C, nlg.h.

Arrays are taken as the docstrings say and never converted: another dtype or shape raises ValueError. Other threads run during every call.
"""
import contextlib
import ctypes
import os
import threading

import numpy as np

LIT, FAINT, UNLIT, OUTSIDE = range(4)
_POINTS = 8192
_LARGEST_THETA = 1e9  # of what light grids hold
_FUNCTIONS_AT_ONCE = 64  # between two looks for Ctrl-C
_CANNOT_OPEN, _CANNOT_READ = 1, 2

_library = ctypes.CDLL(os.path.join(os.path.dirname(os.path.abspath(__file__)), "libnlg.so"))


class _Check(ctypes.Structure):
    _fields_ = [(name, ctypes.c_double) for name in ("rmse", "blend_rmse", "leak_mean", "leak_share")] + [("passes", ctypes.c_int)]


class _Made(ctypes.Structure):
    _fields_ = [("has_theta", ctypes.c_int), ("took_fit", ctypes.c_int), ("ended", ctypes.c_char_p), *((name, _Check) for name in ("network", "corrected", "fitted", "stored")),
                ("elapsed_us", ctypes.c_double)]


for _name, _result in {"status_name": ctypes.c_char_p, "representation_name": ctypes.c_char_p, "theta_count": ctypes.c_size_t, "light_grid_group_name": ctypes.c_char_p,
                       "light_grid_probe_count": ctypes.c_size_t, "light_grid_group_count": ctypes.c_size_t}.items():
    getattr(_library, "nlg_" + _name).restype = _result


def _call(name, *arguments):
    """A function of nlg.h; numbers are sizes, arrays the addresses of what they hold."""
    convert = {np.ndarray: lambda array: array.ctypes.data_as(ctypes.c_void_p), int: ctypes.c_size_t}
    return getattr(_library, "nlg_" + name)(*(convert.get(type(argument), lambda same: same)(argument) for argument in arguments))


def _error(status, detail):
    if status in (_CANNOT_OPEN, _CANNOT_READ):
        return OSError(detail)
    return ValueError(f"{detail} ({_call('status_name', ctypes.c_int(status)).decode()})".lstrip())


def _require(status, detail=""):
    if status != 0:
        raise _error(status, detail)


def _array(name, array, dtype, *shape):
    """The array, its numbers one behind the other. None in a shape: any length."""
    expected = f"{name}: expected {np.dtype(dtype)} of shape ({', '.join('n' if length is None else str(length) for length in shape)}{',' * (len(shape) == 1)}), got "
    if not isinstance(array, np.ndarray):
        raise ValueError(f"{expected}no array but {type(array).__name__}")
    if array.dtype != np.dtype(dtype) or array.ndim != len(shape) or any(wanted not in (None, length) for wanted, length in zip(shape, array.shape)):
        raise ValueError(f"{expected}{array.dtype} of shape {array.shape}")
    return np.ascontiguousarray(array)


def _within(name, array, limit):
    bad = array[~(np.abs(array) <= limit)]  # as the comparison is written, NaN is not within
    if bad.size > 0:
        raise ValueError(f"{name}: expected numbers within ±{limit:g}, got {bad.flat[0]:g}")
    return array


class _Handle:
    """What the library made, and frees by the function of that name."""

    def __init__(self, free, make, *arguments):
        self._free, self._pointer = free, ctypes.c_void_p()
        _require(make(*arguments, ctypes.byref(self._pointer)))

    @property
    def _as_parameter_(self):
        return self._pointer

    def __del__(self):
        if self._pointer:
            _call(self._free, self._pointer)


class _File(_Handle):
    def __init__(self, kind, source):
        detail = ctypes.create_string_buffer(4096)

        def load(pointer):
            if isinstance(source, bytes):
                status = _call(kind + "_load_bytes", source, len(source), pointer, detail, len(detail))
            else:
                path = os.fsencode(source)
                if b"\0" in path:
                    raise ValueError("embedded null byte")
                status = _call(kind + "_load", path, pointer, detail, len(detail))
            _require(status, os.fsdecode(detail.value))
            return 0

        super().__init__(kind + "_free", load)


class LightGrid:
    """LightGrid(source): a light grid, what nlg-bake wrote.

    source: its path (str or os.PathLike), or its bytes. Every byte is checked.
    Raises OSError where the file cannot be read, ValueError where it is damaged or no light grid.
    Any number of threads may use one; mix() waits for their look-ups.
    """

    def __init__(self, source):
        self._grid = _File("light_grid", source)
        self._calm = threading.Condition()
        self._looking_up = 0

    @property
    def probe_positions(self):
        """(n, 3) float64: of all probes, world coordinates, metres."""
        positions = np.empty((_call("light_grid_probe_count", self._grid), 3))
        _call("light_grid_probe_positions", self._grid, positions)
        return positions

    @property
    def groups(self):
        """list of str: names of the groups of light, in the order of mix(). Empty without --light-groups and --light-state."""
        return [_call("light_grid_group_name", self._grid, group).decode() for group in range(_call("light_grid_group_count", self._grid))]

    @property
    def bounds(self):
        """low and high corner, (3,) float64 each: where light can be looked up, world coordinates, metres."""
        low, high = np.empty(3), np.empty(3)
        _call("light_grid_bounds", self._grid, low, high)
        return low, high

    @property
    def mean_radiance(self):
        """(3,) float32: over all directions and probes with weight, for an exposure."""
        rgb = np.zeros(3, np.float32)
        with self._look_up():
            _call("light_grid_mean_radiance", self._grid, rgb)
        return rgb

    def mix(self, colours):
        """Dims, colours and switches the groups of light: later look-ups see the sum of their light, each times its colour.

        colours: (number of groups, 3) float32, linear factors
        """
        rows = _within("colours", _array("colours", colours, np.float32, len(self.groups), 3), np.finfo(np.float32).max)
        with self._calm:
            self._calm.wait_for(lambda: self._looking_up == 0)
            _require(_call("light_grid_mix", self._grid, rows), "colours: light would exceed 2^30")

    def irradiance(self, positions, normals):
        """irradiance(positions, normals) -> rgb, status

        positions: (n, 3) float64, world coordinates, metres
        normals:   (n, 3) float32, of length 1
        rgb:       (n, 3) float32, none below 0
        status:    (n,) uint8: LIT, FAINT, UNLIT or OUTSIDE
        """
        positions_m = _array("positions", positions, np.float64, None, 3)
        rgb, status = np.empty((len(positions_m), 3), np.float32), np.empty(len(positions_m), np.uint8)
        of_normals = _array("normals", normals, np.float32, len(positions_m), 3)
        scratch = _Handle("look_up_scratch_free", _library.nlg_look_up_scratch_create)
        with self._look_up():
            _call("irradiances", self._grid, positions_m, of_normals, len(rgb), rgb, status, scratch)
        return rgb, status

    @contextlib.contextmanager
    def _look_up(self):
        with self._calm:
            self._looking_up += 1
        try:
            yield
        finally:
            with self._calm:
                self._looking_up -= 1
                self._calm.notify_all()


class Generator:
    """Generator(source): a trained generator, what nlg-export wrote.

    source: the path of a weights file (str or os.PathLike), or its bytes. Every byte is checked.
    Raises OSError where the file cannot be read, ValueError where it is damaged or no weights file.
    Any number of threads may use one. Below, P is 8192 and D the numbers of one theta.
    """

    def __init__(self, source):
        self._generator = _File("generator", source)

    @property
    def representation(self):
        """str: what theta stands for, "tent_mlp4"."""
        return _call("representation_name", self._generator).decode()

    @property
    def theta_count(self):
        """int: D."""
        return _call("theta_count", self._generator)

    def generate(self, phi, validity):
        """generate(phi, validity) -> theta: the network alone.

        phi:      (n, P) uint8: functions at support_points(), round(255 phi); 0 at points inside solid
        validity: (n, P / 8) uint8: 1 outside solid, a bit a point, as of make_theta
        theta:    (n, D) float32
        """
        samples = _array("phi", phi, np.uint8, None, _POINTS)
        valid = _array("validity", validity, np.uint8, len(samples), _POINTS // 8)
        theta, scratch = np.empty((len(samples), self.theta_count), np.float32), self._scratch()
        for piece in _pieces(len(samples)):
            _call("generate", self._generator, samples[piece], valid[piece], len(samples[piece]), theta[piece], scratch)
        return theta

    def make_theta(self, phi, validity, blend_sum=None):
        """make_theta(phi, validity, blend_sum=None) -> theta, has_theta, rmse

        The whole policy of a bake, with its defaults: network, check, exact last layer, fits, refinement of what fails, rounding.

        phi:       (n, P) uint8: functions at support_points(), round(255 phi); 0 at points inside solid
        validity:  (n, P / 8) uint8: 1 outside solid, a bit a point: numpy.packbits(valid, axis=1, bitorder="little")
        blend_sum: (n, P) uint8: round(255 min(1, S)), S the sum of the functions of all probes of the cell there; None: 1 everywhere, and
                   points that one probe alone sees may turn black
        theta:     (n, D) float32, rounded as a light grid holds them
        has_theta: (n,) bool: False where the bare tent is enough, and theta is all 0
        rmse:      (n,) float64: of what stands for the function, over valid points

        Ctrl-C is heard.
        """
        samples = _array("phi", phi, np.uint8, None, _POINTS)
        valid = _array("validity", validity, np.uint8, len(samples), _POINTS // 8)
        sums = None if blend_sum is None else _array("blend_sum", blend_sum, np.uint8, len(samples), _POINTS)
        theta, scratch, made = np.empty((len(samples), self.theta_count), np.float32), self._scratch(), (_Made * len(samples))()
        for piece in _pieces(len(samples)):
            count = len(samples[piece])
            of_piece = ctypes.byref(made, piece.start * ctypes.sizeof(_Made))
            _require(_call("make_theta", self._generator, samples[piece], valid[piece], None if sums is None else sums[piece], count, theta[piece], of_piece, scratch))
        return theta, np.array([one.has_theta for one in made], bool), np.array([one.stored.rmse for one in made], float)

    def evaluate(self, theta, points):
        """evaluate(theta, points) -> phi

        theta:  (D,) float32
        points: (n, 3) float32, local coordinates in [-1, 1]; one unit is one probe spacing
        phi:    (n,) float32, not clamped
        """
        numbers = _within("theta", _array("theta", theta, np.float32, self.theta_count), _LARGEST_THETA)
        x, y, z = map(np.ascontiguousarray, _within("points", _array("points", points, np.float32, None, 3), 1.0).T)
        phi = np.empty(len(x), np.float32)
        _call("evaluate", self._generator, numbers, len(x), x, y, z, phi, self._scratch())
        return phi

    def _scratch(self):
        return _Handle("scratch_free", lambda pointer: _library.nlg_scratch_create(self._generator, None, pointer))


def _pieces(count):
    return [slice(first, min(first + _FUNCTIONS_AT_ONCE, count)) for first in range(0, count, _FUNCTIONS_AT_ONCE)]


def support_points():
    """support_points() -> (8192, 3) float32: where functions are sampled, local coordinates in (-1, 1)."""
    points, pattern_hash = ctypes.POINTER(ctypes.c_float)(), ctypes.c_uint64()
    _require(_call("support_pattern", ctypes.byref(points), ctypes.byref(pattern_hash)))
    return np.ctypeslib.as_array(points, (_POINTS, 3)).copy()
