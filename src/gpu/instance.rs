// SPDX-License-Identifier: MIT OR Apache-2.0
use super::error::{Error, OrCall, Result};
use ash::{ext, khr, vk};
use std::{
    env,
    ffi::{c_char, c_void, CStr},
    sync::{Arc, Mutex},
};

/// What the validation layer said, in order.
pub type Messages = Mutex<Vec<String>>;

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Loader, instance and, when validating, the messenger that collects what the layer says.
pub(super) struct Instance {
    pub raw: ash::Instance,
    pub messages: Arc<Messages>,
    /// Labels and object names are on whenever the loader has them: profilers need them without validation, too.
    pub has_debug_utils: bool,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    pub loader: ash::Entry, // last: unloading the library takes every function pointer with it
}

impl Instance {
    /// `more` are extensions that a window system asks for.
    pub fn new(validate: bool, more: &[*const c_char]) -> Result<Self> {
        let loader = unsafe { ash::Entry::load() }?;
        let layers = unsafe { loader.enumerate_instance_layer_properties() }
            .or_call("vkEnumerateInstanceLayerProperties")?;
        if validate && !layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(LAYER)) {
            return Err(Error::NoValidation);
        }
        let offered = unsafe { loader.enumerate_instance_extension_properties(None) }
            .or_call("vkEnumerateInstanceExtensionProperties")?;
        let has = |name: &CStr| offered.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
        let has_debug_utils = validate || has(ext::debug_utils::NAME);
        let portability = has(khr::portability_enumeration::NAME);

        let mut extensions: Vec<*const c_char> = more.to_vec();
        extensions.extend(has_debug_utils.then_some(ext::debug_utils::NAME.as_ptr()));
        extensions.extend(portability.then_some(khr::portability_enumeration::NAME.as_ptr()));
        let layers: &[_] = if validate { &[LAYER.as_ptr()] } else { &[] };
        let app =
            vk::ApplicationInfo::default().application_name(c"whitecap").api_version(vk::API_VERSION_1_3);
        let on = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&on);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&app)
            .enabled_layer_names(layers)
            .enabled_extension_names(&extensions);
        if portability {
            info = info.flags(vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR);
        }
        // Newer layers are configured by their environment, and warn when this older way is mixed in.
        if validate && env::var_os("VK_LAYER_VALIDATE_SYNC").is_none() {
            info = info.push_next(&mut features);
        }
        let raw = match unsafe { loader.create_instance(&info, None) } {
            // What the loader says when it finds no driver.
            Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) => {
                return Err(Error::NoDevice { missing: Vec::new() })
            }
            other => other.or_call("vkCreateInstance")?,
        };

        // From here `Drop` cleans up, also when the messenger fails.
        let mut instance = Self { raw, messages: Arc::default(), has_debug_utils, messenger: None, loader };
        if validate {
            use vk::{DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Kind};
            let api = ext::debug_utils::Instance::new(&instance.loader, &instance.raw);
            let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
                .message_severity(Severity::WARNING | Severity::ERROR)
                .message_type(Kind::VALIDATION | Kind::PERFORMANCE)
                .pfn_user_callback(Some(collect))
                .user_data(Arc::as_ptr(&instance.messages) as *mut c_void);
            let handle = unsafe { api.create_debug_utils_messenger(&info, None) }
                .or_call("vkCreateDebugUtilsMessengerEXT")?;
            instance.messenger = Some((api, handle));
        }
        Ok(instance)
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        unsafe {
            if let Some((api, messenger)) = &self.messenger {
                api.destroy_debug_utils_messenger(*messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

unsafe extern "system" fn collect(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: `user` is `Instance::messages`, and the messenger is destroyed before it.
    let (sink, data) = unsafe { (&*(user as *const Messages), &*data) };
    let (id, text) = unsafe { (data.message_id_name_as_c_str(), data.message_as_c_str()) };
    let [id, text] = [id, text].map(|part| part.unwrap_or(c"").to_string_lossy());
    // Images are in the layout GENERAL for life, see `Image`: the layer would rather have another one for copies.
    if text.contains("For optimal performance") && text.contains("instead of GENERAL") {
        return vk::FALSE;
    }
    if let Ok(mut sink) = sink.lock() {
        sink.push(format!("{id}: {text}"));
    }
    vk::FALSE
}
