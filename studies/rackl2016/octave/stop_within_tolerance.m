% End step 3 when every response is within its tolerance, or after the largest number of iterations.
function [stop, info] = stop_within_tolerance (values, settings)
  deviations = abs (values.residual(1:numel (settings.measured)));
  within = all (deviations(:) <= settings.tolerances(:));
  stop = within || values.iteration >= settings.most_iterations;
  info = "";
end
