"""Mitsuba integrators of exactly the light that is compared: direct light, seen also by way of
mirrors and clear dielectrics; no light between diffuse surfaces, and none that reaches one by way of a mirror."""
import drjit as dr
import mitsuba as mi


def direct(scene_has_specular, depth=12):
    """What renders direct light best: Mitsuba's own where it can, else `Specular` (vectorised only)."""
    if not scene_has_specular:
        return mi.load_dict({'type': 'direct', 'emitter_samples': 1, 'bsdf_samples': 0})
    return specular(depth)


def specular(depth):
    class Specular(mi.SamplingIntegrator):
        def __init__(self, props):
            super().__init__(props)
            self.depth = depth

        @dr.syntax
        def sample(self, scene, sampler, ray, medium=None, active=True):
            ray = mi.Ray3f(ray)
            active = mi.Bool(active)
            light, weight, bounce = mi.Spectrum(0), mi.Spectrum(1), mi.UInt32(0)
            context = mi.BSDFContext()
            seen = mi.Bool(False)
            while active:
                hit = scene.ray_intersect(ray, active)
                seen |= hit.is_valid()
                light += weight * hit.emitter(scene, active).eval(hit, active)
                active &= hit.is_valid()
                bsdf = hit.bsdf(ray)
                rough = active & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
                sampled, radiance = scene.sample_emitter_direction(hit, sampler.next_2d(rough), False, rough)
                # The shadow ray passes clear panes, weakened, and stops at all else.
                towards = hit.spawn_ray_to(sampled.p)
                passing = rough & dr.any(radiance != 0)
                while passing:
                    pane = scene.ray_intersect(towards, passing)
                    passing &= pane.is_valid()
                    through = pane.bsdf(towards)
                    clear = passing & mi.has_flag(through.flags(), mi.BSDFFlags.Null)
                    radiance[passing & ~clear] = 0
                    radiance[clear] *= through.eval_null_transmission(pane, clear)
                    passing &= clear
                    towards[passing] = pane.spawn_ray_to(sampled.p)
                value = bsdf.eval(context, hit, hit.to_local(sampled.d), rough)
                light[rough] += weight * value * radiance
                active &= ~rough
                drawn, factor = bsdf.sample(context, hit, sampler.next_1d(active), sampler.next_2d(active), active)
                weight[active] *= factor
                ray[active] = hit.spawn_ray(hit.to_world(drawn.wo))
                bounce += 1
                active &= (bounce < self.depth) & dr.any(weight != 0)
            return light, seen, []

    mi.register_integrator('kiloray_specular', lambda props: Specular(props))
    return mi.load_dict({'type': 'kiloray_specular'})
