% Residuals of equations 1 and 2, the latter with its weight.
function c = residuals (p, simulated, settings)
  measured = settings.measured(:);
  c = (simulated(:) - measured) ./ measured;
  fastest = rayleigh_time_step (settings.upper(1), settings);
  slowest = rayleigh_time_step (settings.lower(1), settings);
  t = (fastest - rayleigh_time_step (p(1), settings)) / (fastest - slowest);
  c(end + 1) = settings.rayleigh_weight * t;
end

% Equation 3.
function dt = rayleigh_time_step (density, settings)
  shear_modulus = settings.youngs_modulus / (2 * (1 + settings.poissons_ratio));
  dt = pi * settings.radius * sqrt (density / shear_modulus) ...
       / (0.1631 * settings.poissons_ratio + 0.8766);
end
